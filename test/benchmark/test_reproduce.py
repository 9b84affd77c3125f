"""The paper's experiments: fits, verdicts, sweeps, and the smallest piece of the workflow."""

import copy
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import unittest

import numpy

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
WORKFLOW = os.path.join(SOURCE, 'benchmark', 'reproduce')
sys.path.insert(0, WORKFLOW)

import compare  # noqa: E402  the path comes first
import experiments  # noqa: E402
import exponents  # noqa: E402
import hough  # noqa: E402
import page  # noqa: E402
import pair_errors  # noqa: E402
import sweep_cells  # noqa: E402
import verdicts  # noqa: E402

# Where the programs are, set by CMake; without it they are those of the sourced workspace.
PROGRAMS = os.environ.get('MATCHBOX_PROGRAMS')


class ExponentsTest(unittest.TestCase):

    def test_finds_the_power_above_a_fixed_cost(self):
        x = numpy.array([260, 520, 1040, 2080, 4160])
        for exponent in (0.5, 1.0, 1.7):
            fitted = exponents.fit(x, 0.3 + 0.002 * x ** exponent)
            self.assertAlmostEqual(fitted['exponent'], exponent, delta=0.02)
            self.assertAlmostEqual(fitted['fixed'], 0.3, delta=0.02)
            self.assertLess(fitted['deviation'], 0.005)

    def test_a_fixed_cost_flattens_only_the_plain_slope(self):
        x = numpy.array([100, 200, 400, 800, 1600])
        fitted = exponents.fit(x, 1.0 + 0.001 * x)
        self.assertAlmostEqual(fitted['exponent'], 1.0, delta=0.02)
        self.assertLess(fitted['loglog'], 0.5)

    def test_never_has_a_negative_part(self):
        x = numpy.array([1, 2, 4, 8])
        for time in ([1.0, 3.0, 9.0, 27.0], [4.0, 3.0, 2.0, 1.0], [2.0, 2.0, 2.0, 2.0]):
            fitted = exponents.fit(x, time)
            self.assertGreaterEqual(fitted['fixed'], 0.0)
            self.assertGreaterEqual(fitted['factor'], 0.0)

    def test_the_curve_goes_through_the_measurements(self):
        x = numpy.array([1, 2, 4, 8, 16])
        time = 0.5 + 0.1 * x ** 1.5
        numpy.testing.assert_allclose(exponents.evaluate(exponents.fit(x, time), x, 16), time, rtol=0.01)

    def test_refuses_too_few_measurements(self):
        with self.assertRaises(ValueError):
            exponents.fit([1, 2, 4], [1.0, 2.0, 4.0])


ROW = {'test': 'B', 'noise': '1cm', 'matcher': 'olson', 'success_rate': 1.0,
       'translation_mm': {'median': 0.9}, 'heading_mrad': {'median': 0.1}, 'time_ms': {'median': 1.5}}


def row(**changes):
    return dict(copy.deepcopy(ROW), **changes)


class VerdictsTest(unittest.TestCase):

    def test_a_good_row_misses_nothing(self):
        self.assertEqual(verdicts.accuracy_misses(row()), [])
        self.assertEqual(verdicts.time_misses(row()), [])

    def test_says_what_is_missed_in_words(self):
        self.assertEqual(verdicts.accuracy_misses(row(translation_mm={'median': 1.25})), [
            'Olson in test B, range noise 1 cm: the median error is 1.25 mm, more than 1 mm'])
        self.assertIn('0.600 mrad', verdicts.accuracy_misses(row(heading_mrad={'median': 0.6}))[0])
        self.assertIn('98.9 %', verdicts.accuracy_misses(row(success_rate=0.989))[0])
        self.assertIn('2.10 ms', verdicts.time_misses(row(time_ms={'median': 2.1}))[0])

    def test_a_median_that_is_no_number_is_a_miss(self):
        self.assertEqual(len(verdicts.accuracy_misses(row(translation_mm={'median': float('nan')}))), 1)

    def test_hough_in_the_random_world_may_fail_more_often(self):
        self.assertEqual(verdicts.accuracy_misses(row(test='D', matcher='hough', success_rate=0.96)), [])
        self.assertEqual(len(verdicts.accuracy_misses(row(matcher='hough', success_rate=0.96))), 1)

    def test_success_is_asked_where_the_guess_is_wrong(self):
        self.assertEqual(verdicts.accuracy_misses(row(test='A', success_rate=0.5)), [])

    def test_nothing_is_asked_of_the_baseline(self):
        bad = row(matcher='odometry_only', success_rate=0.0, translation_mm={'median': 150.0})
        self.assertEqual(verdicts.accuracy_misses(bad), [])
        self.assertEqual(verdicts.time_misses(bad), [])

    def test_the_page_shows_the_misses(self):
        self.assertIn('<li>too slow.</li>', page.verdict('Not good:', ['too slow'], 'All good.'))
        self.assertNotIn('Not good', page.verdict('Not good:', [], 'All good.'))


class PairErrorsTest(unittest.TestCase):

    def test_errors_are_in_the_frame_of_the_reference(self):
        # The robot looks along +y and drives 1 m; the answer is 10 mm too far and 20 mm to the left.
        with tempfile.TemporaryDirectory() as folder:
            truth, pairs = os.path.join(folder, 'truth.tum'), os.path.join(folder, 'pairs.csv')
            with open(truth, 'w') as file:
                file.write('# stamp x y z qx qy qz qw\n1.0 5 5 0 0 0 %.9f %.9f\n2.0 5 6 0 0 0 %.9f %.9f\n' %
                           ((0.5 ** 0.5,) * 4))
            with open(pairs, 'w') as file:
                file.write('reference_stamp,scan_stamp,x,y\n1.000000,2.000000,1.010,0.020\n')
            x, y = pair_errors.median_errors_mm(pairs, truth)
        self.assertAlmostEqual(x, 10.0, places=4)
        self.assertAlmostEqual(y, 20.0, places=4)


class CompareTest(unittest.TestCase):

    def test_names_what_differs(self):
        first = {'a': [1, {'b': 2}], 'c': 'x'}
        self.assertEqual(compare.differences(first, copy.deepcopy(first)), [])
        self.assertEqual(compare.differences(first, {'a': [1, {'b': 3}], 'c': 'x'}), ['/a/1/b: 2, 3'])
        self.assertEqual(compare.differences(first, {'a': [1, {'b': 2}]}), ['/c: "x", null'])


class ExperimentsTest(unittest.TestCase):

    def test_a_quick_run_keeps_the_ends_of_every_row(self):
        for name, complexity in experiments.COMPLEXITIES.items():
            quick = experiments.complexity_points(name, experiments.SIZES['quick'])
            self.assertGreaterEqual(len(quick), 4)
            self.assertEqual((quick[0], quick[-1]), (complexity.points[0], complexity.points[-1]))
            self.assertEqual(experiments.complexity_points(name, experiments.SIZES['full']),
                             complexity.points)

    def test_settings_of_one_matcher_are_not_the_others(self):
        given = {'olson/step_xy': 0.05, 'map/resolution': 0.1}
        self.assertEqual(experiments.settings_of('olson', given), given)
        self.assertEqual(experiments.settings_of('hough', given), {'map/resolution': 0.1})

    def test_the_truth_of_stata_is_of_the_laser(self):
        self.assertIn('--lever-arm', experiments.truth_options('a/b.gt.laser.poses', None))
        self.assertEqual(experiments.truth_options('a/b.gt.laser.poses', ''), '')
        self.assertEqual(experiments.truth_options('truth.tum', None), '')

    def test_the_paper_has_a_figure_for_every_matcher_and_test(self):
        for test in experiments.TESTS:
            self.assertEqual(set(experiments.PAPER[test]), set(experiments.MATCHERS))


class HoughTest(unittest.TestCase):

    def test_points_of_one_line_vote_for_it(self):
        # y = 2: its normal is at 90 degrees, 2 m from the origin.
        points = numpy.array([[x, 2.0] for x in numpy.arange(-1.0, 1.0, 0.1)])
        votes, edges = hough.domain(points, 180, 0.03)
        row_index, column = numpy.unravel_index(votes.argmax(), votes.shape)
        self.assertEqual(votes.max(), len(points))
        self.assertEqual(column, 90)
        self.assertAlmostEqual(0.5 * (edges[row_index] + edges[row_index + 1]), 2.0, delta=0.03)
        self.assertTrue((votes.sum(axis=0) == len(points)).all())


class SweepTest(unittest.TestCase):

    def read(self, text):
        with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file:
            file.write(text)
            file.flush()
            return sweep_cells.read(file.name)

    def test_matchers_are_not_repeated_for_what_concerns_others(self):
        sweep = self.read('bags: {a: {bag: a.bag}, b: {bag: b.bag}}\nmatchers: [olson, hough]\n'
                          'grid: {olson/step_xy: [0.02, 0.05], map/resolution: [0.05, 0.1]}\nseeds: [1, 2]\n')
        cells = sweep_cells.cells(sweep)
        self.assertEqual(len(cells), len(set(cells)))
        self.assertEqual(sum(cell.matcher == 'olson' for cell in cells), 2 * 4 * 2)
        self.assertEqual(sum(cell.matcher == 'hough' for cell in cells), 2 * 2 * 2)
        settings = sweep_cells.settings(sweep)
        self.assertEqual({cell.setting for cell in cells}, set(settings))

    def test_paths_are_seen_from_the_file(self):
        sweep = self.read('bags: {a: {bag: [x.bag, /y.bag], truth: t.tum}}\nmatchers: [olson]\n')
        recording = sweep_cells.recordings(sweep, '/data/sweep.yaml')['a']
        self.assertEqual(recording.bags, ['/data/x.bag', '/y.bag'])
        self.assertEqual(recording.truth, '/data/t.tum')

    def test_mistakes_are_named(self):
        for text, named in (('bags: {}\nmatchers: [olson]', 'needs bags'), ('[1]', 'needs bags'),
                            ('bags: {a: {bag: x}}\nmatchers: [olson]\nseed: [1]', 'seed'),
                            ('bags: {a/b: {bag: x}}\nmatchers: [olson]', 'a/b'),
                            ('bags: {a: {}}\nmatchers: [olson]', 'simulate or bag'),
                            ('bags: {a: {bag: x, trut: y}}\nmatchers: [olson]', 'trut'), ('{', 'YAML')):
            with self.assertRaisesRegex(sweep_cells.Mistake, named):
                self.read(text)

    def test_the_example_is_understood(self):
        sweep = sweep_cells.read(os.path.join(SOURCE, 'benchmark', 'sweep.yaml'))
        self.assertTrue(sweep_cells.cells(sweep))


def run(*command):
    environment = dict(os.environ)
    if PROGRAMS:
        environment['PATH'] = PROGRAMS + os.pathsep + environment.get('PATH', '')
    return subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


class FrontTest(unittest.TestCase):

    def test_wrong_usage_exits_with_2_and_one_line(self):
        front = os.path.join(SOURCE, 'scripts', 'reproduce')
        with tempfile.TemporaryDirectory() as out:
            for words in (['--truth', 'a.tum'], ['--bag', 'no.bag'], ['--set', 'olson'],
                          ['--sweep', os.path.join(SOURCE, 'package.xml')],
                          ['--sweep', 'no.yaml'], ['--quick', '--sweep', front]):
                done = run(sys.executable, front, '--out', out, *words)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertEqual(done.stderr.count('\n'), 1, done.stderr)


@unittest.skipIf(importlib.util.find_spec('snakemake') is None,
                 'SNAKEMAKE IS NOT INSTALLED, so the workflow is not tested; apt-get install snakemake')
class WorkflowTest(unittest.TestCase):

    def make(self, folder, settings, *options):
        """Makes one cell of table II, and returns what was done: the names of the rules."""
        with open(os.path.join(folder, 'options.json'), 'w') as file:
            json.dump({'size': 'quick', 'settings': settings}, file)
        done = run(sys.executable, '-m', 'snakemake', '--snakefile', os.path.join(WORKFLOW, 'Snakefile'),
                   '--directory', folder, '--configfile', os.path.join(folder, 'options.json'), '--cores', '1',
                   '--scheduler', 'greedy', 'pairs/A/exact/olson/summary.json', *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [line.split()[1].rstrip(':') for line in done.stderr.split('\n') if line.startswith('rule ')]

    def test_makes_a_cell_once_and_again_only_for_its_own_options(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(self.make(folder, {}), ['simulate', 'pairs'])
            with open(os.path.join(folder, 'pairs/A/exact/olson/summary.json')) as file:
                row = json.load(file)['matchers'][0]
            self.assertEqual(row['pairs'], experiments.SIZES['quick'].pairs)
            self.assertEqual(row['success_rate'], 1.0)
            self.assertEqual(self.make(folder, {}), [])
            self.assertEqual(self.make(folder, {'monte_carlo/max_tries': 500}), [])
            self.assertEqual(self.make(folder, {'olson/step_xy': 0.02}), ['pairs'])


if __name__ == '__main__':
    unittest.main()
