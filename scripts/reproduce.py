#!/usr/bin/python3
"""reproduce: the paper's experiments, from nothing to one page, or a sweep over recordings.

A short front of the Snakemake workflow in benchmark/reproduce, which may also be run by hand. A run that was
stopped goes on where it was; one that is repeated with other options makes anew what depends on them."""

import argparse
import fcntl
import importlib.metadata
import json
import os
import shutil
import subprocess
import sys
import tempfile


class Usage(Exception):
    """The command line asks for what cannot be."""


class Failed(Exception):
    """The work cannot be done."""


def workflow_folder():
    """The workflow beside this script in a clone, else where catkin has the package."""
    here = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
    folders = [here]
    if shutil.which('rospack'):
        done = subprocess.run(['rospack', 'find', 'matchbox_slam'], stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True)
        folders.append(done.stdout.strip())
    for folder in folders:
        path = os.path.join(folder, 'benchmark', 'reproduce')
        if os.path.isfile(os.path.join(path, 'Snakefile')):
            return os.path.realpath(path)
    raise Failed('the workflow is missing: source the devel/setup.bash or setup.bash of the workspace')


def existing(path):
    """The full path of a file that is there."""
    if not os.path.isfile(path):
        raise Usage('%s: no such file' % path)
    return os.path.abspath(path)


def settings(words):
    """KEY=VALUE words as a dict."""
    pairs = [word.partition('=') for word in words]
    for key, equals, value in pairs:
        if not key or not equals or not value:
            raise Usage('--set %s: should be KEY=VALUE' % (key + equals))
    return {key: value for key, _, value in pairs}


def profile(name, folder):
    """The folder of a profile: of the workflow's own, a folder, or one of the user's or of the system by name."""
    own = os.path.join(folder, 'profiles')
    for path in (os.path.join(own, name), name):
        if os.path.isfile(os.path.join(path, 'config.yaml')):
            return os.path.abspath(path)
    from snakemake import get_profile_file  # which takes a second
    path = get_profile_file(name, 'config.yaml')
    if path is None:
        raise Usage("--profile: there is no profile '%s'; allowed: %s, a folder with a config.yaml, or the name of one "
                    'that Snakemake finds' % (name, ', '.join(sorted(os.listdir(own)))))
    return os.path.dirname(path)


def check_matcher(match_pairs, matcher, given):
    """Lets the program say what is wrong with parameters; it looks at them before it opens a file."""
    words = [word for item in given.items() for word in ('--set', '%s=%s' % item)]
    done = subprocess.run([match_pairs, os.devnull, '--truth', os.devnull, '--out', os.devnull, '--matcher', matcher] +
                          words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode == 2:
        raise Usage(done.stderr.strip().replace('match_pairs: ', '', 1))


def check_configuration(chosen, match_pairs):
    """Says what is wrong with the parameters, or with the file of a sweep, before anything starts."""
    import experiments
    try:
        if 'sweep' in chosen:
            import sweep_cells
            sweep = sweep_cells.read(chosen['sweep'])
            for matcher in sweep['matchers']:
                check_matcher(match_pairs, matcher, {})
                # Each value alone: all combinations may be many.
                for key, values in sweep['grid'].items():
                    for value in values:
                        check_matcher(match_pairs, matcher, experiments.settings_of(matcher, {key: value}))
            return
        experiments.check_settings(chosen['settings'], '--set')
        experiments.check_map_options(chosen.get('map_options'), '--map-options')
        experiments.words(chosen.get('truth_options'), '--truth-options')
        for matcher in experiments.NAMES:
            check_matcher(match_pairs, matcher, experiments.settings_of(matcher, chosen['settings']))
    except experiments.Mistake as error:
        raise Usage(str(error).replace('\n', ' '))


def find_programs():
    """Says in one line what Snakemake would say in several."""
    import programs
    try:
        found = programs.find()
    except programs.Missing as error:
        raise Failed(str(error))
    try:
        version = importlib.metadata.version('snakemake')
    except importlib.metadata.PackageNotFoundError:
        raise Failed('Snakemake is missing; on Debian install the package snakemake, else: '
                     'pip install "snakemake<8"')
    # Options of its command line and of profiles change with its major version.
    if version.split('.')[0] != '7':
        raise Failed('Snakemake is of version %s, but 7 is needed: pip install "snakemake<8"' % version)
    return found


def options(arguments):
    """What the workflow is told; the same every time, since changes lead to work."""
    if arguments.sweep:
        if arguments.bag or arguments.truth or arguments.quick or arguments.set:
            raise Usage('--sweep has its bags, truths and settings in the file: no --bag, --truth, --set or '
                        '--quick')
        return {'sweep': existing(arguments.sweep)}
    if (arguments.truth or arguments.map_options or arguments.truth_options) and not arguments.bag:
        raise Usage('--truth, --map-options and --truth-options are about a --bag')
    chosen = {'size': 'quick' if arguments.quick else 'full', 'seed': arguments.seed,
              'settings': settings(arguments.set)}
    if arguments.bag:
        chosen['bag'] = [existing(bag) for bag in arguments.bag]
        chosen['truth'] = existing(arguments.truth) if arguments.truth else None
        chosen['map_options'], chosen['truth_options'] = arguments.map_options, arguments.truth_options
    return chosen


def make_folder(out):
    """With its parents, unless it is there."""
    try:
        os.makedirs(out, exist_ok=True)
    except OSError as error:
        raise Failed("the folder '%s' cannot be made: %s" % (out, error.strerror))


def lock(out):
    """Holds the folder until this process ends, however it does; Snakemake's own lock outlives it."""
    descriptor = os.open(os.path.join(out, '.reproduce.lock'), os.O_RDWR | os.O_CREAT, 0o644)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise Failed('%s: another run is writing there' % out)
    # Snakemake takes the place of this process.
    os.set_inheritable(descriptor, True)


def snakemake(arguments, folder, out, chosen):
    """Snakemake's command line; chosen: the file of the options."""
    # The system's Python has rosbag and matplotlib.
    command = [sys.executable, '-m', 'snakemake', '--directory', out, '--nolock', '--rerun-incomplete',
               '--keep-going', '--scheduler', 'greedy', '--configfile', chosen,
               '--snakefile', os.path.join(folder, 'sweep.smk' if arguments.sweep else 'Snakefile')]
    if arguments.profile:
        command += ['--profile', arguments.profile]
    if arguments.cores or not arguments.profile:
        command += ['--cores', str(arguments.cores or os.cpu_count())]
    if arguments.dry_run:
        return command + ['--dry-run', '--quiet', 'rules']
    if not arguments.verbose:
        command += ['--log-handler-script', os.path.join(folder, 'progress.py')]
    return command


def whole(least, most):
    """A type of the command line: whole numbers within bounds."""
    def convert(text):
        if not text.isascii() or not text.isdigit() or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError('%s: should be a whole number, %d to %d' % (text, least, most))
        return int(text)
    return convert


class OneLineParser(argparse.ArgumentParser):
    """Says what is wrong in one line."""

    def error(self, message):
        self.exit(2, '%s: %s; see --help\n' % (self.prog, message))


def parse():
    parser = OneLineParser(prog='reproduce', description=__doc__,
                           formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--out', metavar='DIR', required=True,
                        help='folder for everything; the page is DIR/index.html')
    parser.add_argument('--quick', action='store_true', help='fewer trials and shorter bags, of a given one the first minute: takes about a '
                        'minute')
    parser.add_argument('--bag', nargs='+', metavar='BAG',
                        help='recording for figures 2 to 9; default: a simulated one')
    parser.add_argument('--truth', metavar='FILE', help='of the recording: TUM, or *.gt.laser.poses of the '
                        'MIT Stata Center data set')
    parser.add_argument('--map-options', metavar='WORDS', default='',
                        help='options of map_bag for the recording, such as "--scan-topic /scan"')
    parser.add_argument('--truth-options', metavar='WORDS',
                        help='options of `evaluate ate` for the truth; for the MIT Stata Center '
                        '"--lever-arm 0.275 --find-offset"')
    parser.add_argument('--set', metavar='KEY=VALUE', action='append', default=[],
                        help='a parameter; those of one matcher concern it alone; may be given repeatedly')
    parser.add_argument('--seed', metavar='N', type=whole(0, 2 ** 31 - 1), default=1)
    parser.add_argument('--sweep', metavar='FILE.yaml',
                        help='instead of the experiments: map every bag with every matcher and setting of '
                        'the file')
    parser.add_argument('--cores', metavar='N', type=whole(1, 100000), help='default: all')
    parser.add_argument('--profile', metavar='P', help="Snakemake's, for a cluster: `slurm`, a folder, or "
                        'the name of one of yours')
    parser.add_argument('--dry-run', action='store_true', help='only say what would be done')
    parser.add_argument('--verbose', action='store_true', help='tell every job')
    return parser.parse_args()


def main():
    arguments = parse()
    try:
        chosen = options(arguments)
        folder = workflow_folder()
        sys.dont_write_bytecode = True
        sys.path.insert(0, folder)
        if not arguments.out:
            raise Usage("--out: '' is no name of a folder")
        programs = find_programs()
        if arguments.profile:
            arguments.profile = profile(arguments.profile, folder)
        check_configuration(chosen, programs['match_pairs'])
        out = os.path.abspath(arguments.out)
        make_folder(out)
        lock(out)
        if arguments.dry_run:
            # The options of the run that is there stay what they are.
            with tempfile.NamedTemporaryFile('w', suffix='.json') as file:
                json.dump(chosen, file)
                file.flush()
                return subprocess.run(snakemake(arguments, folder, out, file.name)).returncode
        path = os.path.join(out, 'options.json')
        with open(path, 'w') as file:
            json.dump(chosen, file, indent=1, sort_keys=True)
        command = snakemake(arguments, folder, out, path)
        os.execv(command[0], command)
    except Usage as error:
        print('reproduce: %s; see --help' % error, file=sys.stderr)
        return 2
    except (Failed, OSError) as error:
        print('reproduce: %s' % error, file=sys.stderr)
        return 1


if __name__ == '__main__':
    sys.exit(main())
