"""The paper's experiments: programs, sweeps, wrong usage, and the smallest piece of the workflow."""

import csv
import glob
import importlib.metadata
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from reproduce_support import PROGRAMS, SOURCE, WORKFLOW, read_text, run, write  # its modules are found from here on
import experiments
import programs
import sweep_cells
import sweep_page


class ProgramsTest(unittest.TestCase):

    def test_only_what_a_program_consists_of_counts(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ('matchbox_slam/map_bag', 'matchbox_slam/evaluate', 'matchbox_slam/plot_evaluation',
                         'libmatchbox_slam_plugins.so', 'libmatchbox_slam_nodelet.so'):
                write(folder, name, name)

            def fingerprints():
                return [programs.fingerprint(os.path.join(folder, 'matchbox_slam', name))
                        for name in ('map_bag', 'evaluate')]
            first = fingerprints()
            write(folder, 'libmatchbox_slam_nodelet.so', 'anew')
            self.assertEqual(fingerprints(), first)
            write(folder, 'libmatchbox_slam_plugins.so', 'anew')
            second = fingerprints()
            self.assertEqual([second[0] == first[0], second[1] == first[1]], [False, True])
            write(folder, 'matchbox_slam/plot_evaluation', 'anew')
            third = fingerprints()
            self.assertEqual([third[0] == second[0], third[1] == second[1]], [True, False])


class SlurmStatusTest(unittest.TestCase):

    def status(self, sacct, squeue, up=True):
        with tempfile.TemporaryDirectory() as folder:
            for name, says in (('sacct', sacct), ('squeue', squeue),
                               ('scontrol', 'Slurmctld(primary) at a is UP' if up else '')):
                write(folder, name, "#!/bin/sh\nprintf '%s'\n" % says)
                os.chmod(os.path.join(folder, name), 0o755)
            done = subprocess.run(['bash', os.path.join(WORKFLOW, 'profiles', 'slurm', 'status.sh'), '7;cluster'],
                                  env={'PATH': folder + ':/usr/bin:/bin'}, stdout=subprocess.PIPE, text=True)
            return done.stdout.strip()

    def test_says_what_snakemake_asks(self):
        self.assertEqual(self.status('COMPLETED\\nCOMPLETED', ''), 'success')
        self.assertEqual(self.status('CANCELLED by 0\\n', ''), 'failed')
        self.assertEqual(self.status('', 'OUT_OF_MEMORY'), 'failed')
        self.assertEqual(self.status('', 'PENDING'), 'running')
        # Nobody knows it any more; or nobody is there to ask.
        self.assertEqual(self.status('', ''), 'failed')
        self.assertEqual(self.status('', '', up=False), 'running')


class SweepTest(unittest.TestCase):

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        for name in ('x.bag', 't.tum'):
            write(self.folder.name, name, '')

    def read(self, text):
        write(self.folder.name, 'sweep.yaml', text)
        return sweep_cells.read(os.path.join(self.folder.name, 'sweep.yaml'))

    def test_matchers_are_not_repeated_for_what_concerns_others(self):
        sweep = self.read('bags: {a: {bag: x.bag}, b: {bag: x.bag}}\nmatchers: [olson, hough]\n'
                          'grid: {olson/step_xy: [0.02, 0.05], map/resolution: [0.05, 0.1]}\nseeds: [1, 2]\n')
        cells = sweep_cells.cells(sweep)
        self.assertEqual(len(cells), len(set(cells)))
        self.assertEqual(sum(cell.matcher == 'olson' for cell in cells), 2 * 4 * 2)
        self.assertEqual(sum(cell.matcher == 'hough' for cell in cells), 2 * 2 * 2)
        settings = sweep_cells.settings(sweep)
        self.assertEqual({cell.setting for cell in cells}, set(settings))

    def test_paths_are_seen_from_the_file(self):
        sweep = self.read('bags: {a: {bag: [x.bag, %s/x.bag], truth: t.tum}}\nmatchers: [olson]\n' %
                          self.folder.name)
        recording = sweep_cells.recordings(sweep, '/data/sweep.yaml')['a']
        self.assertEqual(recording.bags, ['/data/x.bag', self.folder.name + '/x.bag'])
        self.assertEqual(recording.truth, '/data/t.tum')

    def test_folders_have_short_names_without_separators(self):
        settings = {'a/b%d' % i: 'c/d e' for i in range(3)}
        self.assertEqual(sweep_cells.name_of({'a/b': 'c d'}), 'a.b=c%20d')
        self.assertNotIn('/', sweep_cells.name_of(settings))
        long = {'group/a_long_key_%d' % i: 0.05 for i in range(20)}
        self.assertLess(len(sweep_cells.name_of(long)), 40)
        self.assertNotEqual(sweep_cells.name_of(long), sweep_cells.name_of(dict(long, more=1)))

    def test_truth_values_are_yaml_words(self):
        sweep = self.read('bags: {a: {bag: x.bag}}\nmatchers: [olson]\ngrid: {map/a: [true, false]}')
        self.assertEqual(sweep['grid'], {'map/a': ['true', 'false']})

    def test_mistakes_are_named(self):
        bag, matchers = 'bags: {a: {bag: x.bag}}\n', '\nmatchers: [olson]'
        for text, named in (
                ('bags: {}' + matchers, 'needs bags'), ('[1]', 'needs bags'), ('{', 'YAML'),
                (bag + 'seed: [1]' + matchers, 'seed'), ('bags: [x.bag]' + matchers, 'each needs a name'),
                ('bags: {a/b: {bag: x.bag}}' + matchers, 'a/b'), ('bags: {..: {bag: x.bag}}' + matchers, 'letters'),
                ('bags: {2012-01-25: {bag: x.bag}}' + matchers, 'quotes'), ('bags: {7: {bag: x.bag}}' + matchers, 'quotes'),
                ('bags: {a: {bag: x.bag}, a: {bag: x.bag}}' + matchers, 'a is given twice'),
                ('bags: {a: {}}' + matchers, 'simulate or bag'), ('bags: {a: x.bag}' + matchers, 'simulate or bag'),
                ('bags: {a: {bag: x.bag, trut: y}}' + matchers, 'trut'), ('bags: {a: {bag: }}' + matchers, 'list'),
                ('bags: {a: {bag: []}}' + matchers, 'list'), ('bags: {a: {bag: y.bag}}' + matchers, 'y.bag: no such'),
                ('bags: {a: {bag: x.bag, truth: y.tum}}' + matchers, 'y.tum: no such'),
                ('bags: {a: {bag: x.bag, truth: [t.tum]}}' + matchers, 'truth'),
                ('bags: {a: {simulate: rooms}}' + matchers, 'world: rooms'),
                ('bags: {a: {simulate: {world: rooms}, truth: t.tum}}' + matchers, 'has its truth'),
                ('bags: {a: {bag: x.bag, map_options: --seed 3}}' + matchers, '--seed'),
                ('bags: {a: {bag: x.bag, map_options: [3]}}' + matchers, 'map_options'),
                (bag + 'matchers: olson', 'list'), (bag + 'matchers: [olson, olson]', 'twice'),
                (bag + 'matchers: [a/b]', 'letters'), (bag + 'seeds: 3' + matchers, 'list'),
                (bag + 'seeds: [a]' + matchers, 'a cannot'), (bag + 'seeds: [-1]' + matchers, '-1'),
                (bag + 'grid: {a: 1}' + matchers, 'list'), (bag + 'grid: {a: [[1]]}' + matchers, 'cannot'),
                (bag + 'grid: [a]' + matchers, 'grid'), (bag + 'grid: {seed: [1, 2]}' + matchers, 'workflow sets'),
                (bag + 'grid: {a: [1, 1]}' + matchers, 'twice')):
            with self.assertRaisesRegex(experiments.Mistake, named, msg=text):
                self.read(text)

    def test_the_example_is_understood(self):
        sweep = sweep_cells.read(os.path.join(SOURCE, 'benchmark', 'sweep.yaml'))
        self.assertTrue(sweep_cells.cells(sweep))

    def test_seeds_are_put_together_best_first(self):
        def cell(matcher, seed, error):
            return {'bag': 'a', 'matcher': matcher, 'setting': 'default', 'seed': seed, 'status': 'ok',
                    'ate_rmse_m': error}
        table = sweep_page.aggregate([cell('hough', 1, 0.3), cell('hough', 2, 0.5), cell('olson', 1, 0.1),
                                      {'bag': 'a', 'matcher': 'olson', 'setting': 'default', 'status': 'failed: x'}])
        self.assertEqual([row.cells[1] for row in table.rows], ['olson', 'hough'])
        self.assertEqual([row.cells[3:5] for row in table.rows],
                         [['1 of 2', '0.1000'], ['2 of 2', '0.4000 ± 0.1414']])


FRONT = os.path.join(SOURCE, 'scripts', 'reproduce.py')


def snakemake_version():
    try:
        return importlib.metadata.version('snakemake')
    except importlib.metadata.PackageNotFoundError:
        return 'none'


@unittest.skipIf(snakemake_version().split('.')[0] not in ('7', 'none'),
                 'REPRODUCE IS NOT TESTED: it refuses Snakemake ' + snakemake_version())
class FrontTest(unittest.TestCase):

    def test_wrong_usage_exits_with_2_and_one_line(self):
        with tempfile.TemporaryDirectory() as out:
            write(out, 'sweep.yaml', 'bags: {a: {simulate: {world: rooms}}}\nmatchers: [olsn]\n')
            for words, named in (
                    (['--truth', 'a.tum'], '--bag'), (['--bag', 'no.bag'], 'no.bag'), (['--set', 'olson'], 'KEY'),
                    (['--sweep', os.path.join(SOURCE, 'package.xml')], 'YAML|bags'), (['--sweep', 'no.yaml'], 'no.yaml'),
                    (['--quick', '--sweep', FRONT], '--sweep'), (['--set', 'matcher=hough'], 'matcher'),
                    (['--set', 'seed=3'], 'seed'), (['--set', 'olsn/step_xy=1'], 'olsn'), (['--seed', '-1'], 'seed'),
                    (['--cores', '-2'], 'cores'), (['--cores', '0'], 'cores'), (['--seed', 'x'], 'seed'),
                    (['--bag', FRONT, '--map-options', '--seed 3'], '--seed'),
                    (['--sweep', os.path.join(out, 'sweep.yaml')], 'olsn'), (['--profile', 'nope'], "'nope'.* slurm")):
                done = run(sys.executable, FRONT, '--out', os.path.join(out, 'results'), *words)
                self.assertEqual(done.returncode, 2, (words, done.stderr))
                self.assertEqual(done.stderr.count('\n'), 1, done.stderr)
                self.assertRegex(done.stderr, '^reproduce: .*(%s)' % named)
            self.assertFalse(os.path.exists(os.path.join(out, 'results')))

    def test_a_folder_that_cannot_be_made_is_one_line(self):
        done = run(sys.executable, FRONT, '--out', '/dev/null/results')
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stderr, "reproduce: the folder '/dev/null/results' cannot be made: Not a directory\n")
        done = run(sys.executable, FRONT, '--out', '')
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr, "reproduce: --out: '' is no name of a folder; see --help\n")

    @unittest.skipIf(shutil.which('rosrun') is None or shutil.which('catkin_find') is None, 'rosrun is missing')
    def test_rosrun_finds_the_scripts_once(self):
        # In a clone that holds a workspace of its own, whose package is made of links.
        with tempfile.TemporaryDirectory() as clone:
            for name in ('package.xml', 'scripts'):
                (shutil.copytree if name == 'scripts' else shutil.copy)(os.path.join(SOURCE, name),
                                                                       os.path.join(clone, name))
            inner = os.path.join(clone, '.workspace', 'src', 'matchbox_slam')
            os.makedirs(inner)
            os.symlink(os.path.join(clone, 'scripts'), os.path.join(inner, 'scripts'))
            found = run('find', '-L', clone, '-type', 'f', '-perm', '/111').stdout.split()
            names = [os.path.basename(path) for path in found]
            for program in ('reproduce', 'plot_evaluation'):
                self.assertNotIn(program, names)
            self.assertIn('reproduce.py', names)


@unittest.skipIf(snakemake_version().split('.')[0] != '7',
                 'THE WORKFLOW IS NOT TESTED: it needs Snakemake 7, and here is ' + snakemake_version())
class WorkflowTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def make(self, settings):
        """Makes one cell of table II, and returns what was done: the names of the rules."""
        write(self.folder, 'options.json', {'size': 'quick', 'settings': settings})
        done = run(sys.executable, '-m', 'snakemake', '--snakefile', os.path.join(WORKFLOW, 'Snakefile'),
                   '--directory', self.folder, '--configfile', os.path.join(self.folder, 'options.json'),
                   '--cores', '1', '--scheduler', 'greedy', 'pairs/A/exact/olson/summary.json')
        self.assertEqual(done.returncode, 0, done.stderr)
        return [line.split()[1].rstrip(':') for line in done.stderr.split('\n') if line.startswith('rule ')]

    def test_makes_a_cell_once_and_again_only_for_its_own_options(self):
        self.assertEqual(self.make({}), ['simulate', 'pairs'])
        with open(os.path.join(self.folder, 'pairs/A/exact/olson/summary.json')) as file:
            row = json.load(file)['matchers'][0]
        self.assertEqual(row['pairs'], experiments.SIZES['quick'].pairs)
        self.assertEqual(row['success_rate'], 1.0)
        self.assertEqual(self.make({'monte_carlo/max_tries': 500}), [])
        self.assertEqual(self.make({'olson/step_xy': 0.02}), ['pairs'])

    def sweep(self, text, *words):
        write(self.folder, 'sweep.yaml', text)
        return run(sys.executable, FRONT, '--sweep', os.path.join(self.folder, 'sweep.yaml'), '--out',
                   os.path.join(self.folder, 'out'), '--cores', '2', *words)

    def rows(self):
        with open(os.path.join(self.folder, 'out', 'sweep.csv')) as file:
            return list(csv.DictReader(file))

    def page(self):
        return read_text(self.folder, 'out', 'index.html')

    def test_sweeps_with_and_without_truth_and_tells_what_failed(self):
        simulated = '{simulate: {world: rooms, seed: 1, duration: 12, beams: 200}}'
        done = self.sweep('bags: {made: %s}\nmatchers: [olson]\n' % simulated)
        self.assertEqual(done.returncode, 0, done.stderr)
        row, = self.rows()
        self.assertLess(float(row['ate_rmse_m']), 0.05)
        self.assertIn('made</td>', self.page())
        # The same bag without a truth, beside one that is none; errors of the first run lie about.
        bag = os.path.join(self.folder, 'out', 'bags', 'made.bag')
        shutil.copy(bag, os.path.join(self.folder, 'given.bag'))
        shutil.copytree(os.path.join(self.folder, 'out', 'maps', 'made'),
                        os.path.join(self.folder, 'out', 'maps', 'given'))
        write(self.folder, 'broken.bag', 'no bag')
        text = 'bags: {given: {bag: given.bag}, broken: {bag: broken.bag}}\nmatchers: [olson]\n'
        done = self.sweep(text, '--dry-run')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn('made</td>', self.page())
        done = self.sweep(text)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(done.stderr.count('FAILED: map bag broken'), 1, done.stderr)
        given, broken = self.rows()
        self.assertEqual((given['status'], given['ate_rmse_m']), ('ok', ''))
        self.assertIn('failed: map_bag: ', broken['status'])
        self.assertIn('failed: map_bag: ', self.page())
        self.assertNotIn('made</td>', self.page())

    def test_goes_on_after_a_kill(self):
        write(self.folder, 'sweep.yaml', 'bags: {a: {simulate: {world: rooms, seed: 1, duration: 12, beams: 200}}}\n'
              'matchers: [olson]\nseeds: [1, 2, 3, 4]\n')
        environment = dict(os.environ)
        if PROGRAMS:
            environment['PATH'] = PROGRAMS + os.pathsep + environment['PATH']
        out = os.path.join(self.folder, 'out')
        process = subprocess.Popen(
            [sys.executable, FRONT, '--sweep', os.path.join(self.folder, 'sweep.yaml'), '--out', out, '--cores', '1'],
            env=environment, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL, start_new_session=True)
        bag, page = os.path.join(out, 'bags', 'a.bag'), os.path.join(out, 'index.html')
        deadline = time.monotonic() + 60
        reports = os.path.join(out, 'maps', 'a', 'olson', 'default', '*', 'report.json')
        while not glob.glob(reports) and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        self.assertTrue(os.path.exists(bag))
        self.assertFalse(os.path.exists(page))
        made = os.stat(bag).st_mtime_ns
        again = run(sys.executable, FRONT, '--sweep', os.path.join(self.folder, 'sweep.yaml'), '--out', out)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(os.stat(bag).st_mtime_ns, made)
        with open(os.path.join(out, 'sweep.csv')) as file:
            self.assertEqual([row['status'] for row in csv.DictReader(file)], ['ok'] * 4)


if __name__ == '__main__':
    unittest.main()
