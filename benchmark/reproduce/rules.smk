# What the paper's experiments and the sweep share: bags are simulated, mapped and measured, one job a cell.
#
# The file that includes this one first defines, besides what it imports,
#   SIMULATED   {name: options of simulate}: bags made here
#   RECORDINGS  {name: Recording}: what is mapped
#   SETTINGS    {name: {key: value}}: parameters of map_bag
#
# Each job's log begins with its command, and ends with what its program said. A job that fails leaves its
# log and no results; the page then says so.
import os
import shlex
import sys

import experiments
import programs

try:
    PROGRAM = programs.find()
except programs.Missing as error:
    raise WorkflowError(str(error))
PYTHON = sys.executable
HERE = workflow.basedir
# Among the parameters of each job: results of other programs are made anew.
FINGERPRINT = {name: programs.fingerprint(path) for name, path in PROGRAM.items()}
CELL = 'maps/{bag}/{matcher}/{setting}/{seed}'


def script(name):
    return os.path.join(HERE, name)


def set_flags(settings):
    return ' '.join('--set ' + shlex.quote('%s=%s' % item) for item in settings.items())


def quoted(words):
    return ' '.join(map(shlex.quote, words))


# Matchers of other people's packages, too: any name, but no folder.
wildcard_constraints:
    bag=r'[^/]+',
    matcher=r'[^/]+',
    setting=r'[^/]+',
    seed=r'\d+'


# What is to be made anew is removed first: whatever happens, nothing is left that belongs to other inputs.
onstart:
    for job in workflow.persistence.dag.needrun_jobs():
        for path in job.output:
            if os.path.exists(path):
                os.remove(path)


rule simulate:
    output:
        bag='bags/{bag}.bag',
        truth='bags/{bag}.tum'
    log:
        'bags/{bag}.log'
    params:
        options=lambda wildcards: experiments.flags(SIMULATED[wildcards.bag]),
        program=FINGERPRINT['simulate']
    shell:
        '(set -x; {PROGRAM[simulate]:q} {params.options} --bag {output.bag:q} --truth {output.truth:q} '
        '>/dev/null) 2>{log:q}'


rule map_bag:
    input:
        lambda wildcards: RECORDINGS[wildcards.bag].bags
    output:
        trajectory=CELL + '/trajectory.tum',
        odometry=CELL + '/odometry.tum',
        picture=CELL + '/map.pgm',
        map=CELL + '/map.yaml',
        report=CELL + '/report.json'
    log:
        CELL + '/map_bag.log'
    params:
        folder=CELL,
        settings=lambda wildcards: set_flags(
            experiments.settings_of(wildcards.matcher, SETTINGS[wildcards.setting])),
        options=lambda wildcards: quoted(RECORDINGS[wildcards.bag].map_options),
        program=FINGERPRINT['map_bag']
    shell:
        '(set -x; {PROGRAM[map_bag]:q} {input:q} --out {params.folder:q} --matcher {wildcards.matcher:q} '
        '--seed {wildcards.seed} --quiet {params.settings} {params.options}) 2>{log:q}'


rule trajectory_error:
    input:
        trajectory=CELL + '/trajectory.tum',
        odometry=CELL + '/odometry.tum',
        truth=lambda wildcards: RECORDINGS[wildcards.bag].truth
    output:
        errors=CELL + '/ate.json',
        plot=CELL + '/ate.png'
    log:
        CELL + '/ate.log'
    params:
        name=lambda wildcards: experiments.NAMES.get(wildcards.matcher, wildcards.matcher),
        options=lambda wildcards: quoted(RECORDINGS[wildcards.bag].truth_options),
        program=FINGERPRINT['evaluate']
    # The legend names the files; those of all cells have the same names. Without odometry its file is empty.
    shell:
        '(work=$(mktemp -d) && trap \'rm -r "$work"\' EXIT && '
        'cp {input.trajectory:q} "$work"/{params.name:q} && set -- "$work"/{params.name:q} && '
        'if [ -s {input.odometry:q} ]; then cp {input.odometry:q} "$work/odometry"; '
        'set -- "$@" "$work/odometry"; fi && set -x; '
        '{PROGRAM[evaluate]:q} ate "$@" --truth {input.truth:q} '
        '{params.options} --json --plot {output.plot:q} >{output.errors:q}) 2>{log:q}'


rule map_quality:
    input:
        map=CELL + '/map.yaml',
        picture=CELL + '/map.pgm'
    output:
        CELL + '/quality.json'
    log:
        CELL + '/quality.log'
    params:
        program=FINGERPRINT['evaluate']
    shell:
        '(set -x; {PROGRAM[evaluate]:q} map {input.map:q} --json >{output:q}) 2>{log:q}'
