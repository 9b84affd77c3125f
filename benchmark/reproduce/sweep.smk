# Maps every bag of a sweep.yaml with every matcher, setting and seed: `reproduce --sweep FILE`, or
#
#   snakemake --snakefile benchmark/reproduce/sweep.smk --directory OUT --cores 2 --config sweep=FILE
import os
import shlex
import sys

sys.path.insert(0, workflow.basedir)
import experiments
import sweep_cells

if 'sweep' not in config:
    raise WorkflowError('which sweep? --config sweep=FILE')
try:
    SWEEP = sweep_cells.read(config['sweep'])
except (OSError, sweep_cells.Mistake) as error:
    raise WorkflowError(str(error))
SIMULATED = {name: entry['simulate'] for name, entry in SWEEP['bags'].items() if 'simulate' in entry}
RECORDINGS = sweep_cells.recordings(SWEEP, config['sweep'])
SETTINGS = sweep_cells.settings(SWEEP)
CELLS = sweep_cells.cells(SWEEP)

include: 'rules.smk'


def cell_files(name, cells):
    return [os.path.join(CELL.format(**cell._asdict()), name) for cell in cells]


onsuccess:
    print('The page: ' + os.path.abspath('index.html'))


rule all:
    input:
        'index.html'


rule sweep_page:
    input:
        script('sweep_page.py'), script('page.css'), script('page.py'),
        reports=cell_files('report.json', CELLS),
        qualities=cell_files('quality.json', CELLS),
        errors=cell_files('ate.json', [cell for cell in CELLS if RECORDINGS[cell.bag].truth])
    output:
        page='index.html',
        table='sweep.csv'
    params:
        cells=cell_files('', CELLS),
        commit=programs.commit() or '',
        programs=FINGERPRINT
    # The list of cells may be longer than a command line can be.
    run:
        import sweep_page
        sweep_page.write(params.cells, params.commit, params.programs, output.table, output.page)
