# Maps every bag of a sweep.yaml with every matcher, setting and seed: `reproduce --sweep FILE`, or
#
#   snakemake --snakefile benchmark/reproduce/sweep.smk --directory OUT --cores 2 --config sweep=FILE
import os
import sys

sys.path.insert(0, workflow.basedir)
import experiments
import sweep_cells

if 'sweep' not in config:
    raise WorkflowError('which sweep? --config sweep=FILE')
try:
    SWEEP = sweep_cells.read(config['sweep'])
except (OSError, experiments.Mistake) as error:
    raise WorkflowError(str(error))
SIMULATED = {name: entry['simulate'] for name, entry in SWEEP['bags'].items() if 'simulate' in entry}
RECORDINGS = sweep_cells.recordings(SWEEP, config['sweep'])
SETTINGS = sweep_cells.settings(SWEEP)
CELLS = sweep_cells.cells(SWEEP)

include: 'rules.smk'


def cell_files(name, cells):
    return [os.path.join(CELL.format(**cell._asdict()), name) for cell in cells]


# The list of cells may be longer than a command line can be.
def tell(page='index.html', table='sweep.csv'):
    import sweep_page
    rows = [sweep_page.Row(CELL.format(**cell._asdict()), cell, SETTINGS[cell.setting],
                           RECORDINGS[cell.bag].truth is not None) for cell in CELLS]
    sweep_page.write(rows, table, page)


onsuccess:
    print('The page: ' + os.path.abspath('index.html'))


onerror:
    tell()
    print('Something failed, which the page tells: ' + os.path.abspath('index.html'))


rule all:
    input:
        'index.html'


rule sweep_page:
    input:
        [script(name) for name in ('experiments.py', 'files.py', 'html_page.py', 'page.css', 'results.py',
                                   'sweep_cells.py', 'sweep_page.py', 'tables.py')],
        cell_files('report.json', CELLS),
        cell_files('quality.json', CELLS),
        cell_files('ate.json', [cell for cell in CELLS if RECORDINGS[cell.bag].truth])
    output:
        page='index.html',
        table='sweep.csv'
    run:
        tell(output.page, output.table)
