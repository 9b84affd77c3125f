"""The paper's experiments: fits, verdicts, tables and the page."""

import copy
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import matplotlib.figure
import numpy

from reproduce_support import SOURCE, WORKFLOW, read_text, run, write  # its modules are found from here on
import compare
import draw_maps
import experiments
import exponents
import files
import hough
import page
import pair_errors
import results
import tables
import verdicts


def repeated(times):
    """Samples in which every trial took the same time."""
    return [[time] * 5 for time in times]


class ExponentsTest(unittest.TestCase):

    def test_finds_the_power_above_a_fixed_cost(self):
        x = numpy.array([260, 520, 1040, 2080, 4160])
        for exponent in (0.5, 1.0, 1.7):
            fitted = exponents.fit(x, repeated(0.3 + 0.002 * x ** exponent))
            self.assertAlmostEqual(fitted['exponent'], exponent, delta=0.02)
            self.assertAlmostEqual(fitted['fixed'], 0.3, delta=0.02)
            self.assertLess(fitted['deviation'], 0.005)
            numpy.testing.assert_allclose(fitted['interval'], fitted['exponent'])

    def test_never_has_a_negative_part(self):
        x = numpy.array([1, 2, 4, 8])
        for time in ([1.0, 3.0, 9.0, 27.0], [4.0, 3.0, 2.0, 1.0], [2.0, 2.0, 2.0, 2.0], [0.1, 2.0, 9.0, 80.0]):
            fitted = exponents.fit(x, repeated(time))
            self.assertGreaterEqual(fitted['fixed'], 0.0)
            self.assertGreaterEqual(fitted['factor'], 0.0)

    def test_no_pair_of_constants_fits_better(self):
        generator = numpy.random.default_rng(2)
        x = numpy.array([1.0, 2.0, 4.0, 8.0, 16.0])
        for _ in range(5):
            time = generator.uniform(1.0, 5.0, 5)
            fitted = exponents.fit(x, repeated(time))

            def deviation(a, b):
                return numpy.sqrt(numpy.mean(
                    ((a + b * (x / 16.0) ** fitted['exponent']) / time - 1.0) ** 2))
            self.assertAlmostEqual(deviation(fitted['fixed'], fitted['factor']), fitted['deviation'], delta=1e-6)
            for a in fitted['fixed'] + numpy.array([-0.1, 0.0, 0.1]):
                for b in fitted['factor'] + numpy.array([-0.1, 0.0, 0.1]):
                    if a >= 0.0 and b >= 0.0:
                        self.assertLessEqual(fitted['deviation'], deviation(a, b) + 1e-9)

    def test_the_curve_goes_through_the_measurements(self):
        x = numpy.array([1, 2, 4, 8, 16])
        time = 0.5 + 0.1 * x ** 1.5
        fitted = exponents.fit(x, repeated(time))
        numpy.testing.assert_allclose(exponents.evaluate(fitted, x, 16), time, rtol=0.01)

    def test_the_interval_is_that_of_the_noise(self):
        generator = numpy.random.default_rng(1)
        x = numpy.array([1.0, 2.0, 4.0, 8.0, 16.0, 32.0])

        def width(noise):
            low, high = exponents.fit(x, [generator.normal(value, noise * value, 50) for value in x])['interval']
            self.assertLess(low, high)
            return high - low
        self.assertLess(width(0.1), 0.2)
        self.assertGreater(width(1.0), 0.3)

    def test_outliers_do_not_move_it(self):
        x = numpy.array([1, 2, 4, 8])
        samples = repeated(0.1 * x)
        samples[3][0] = 8.0
        self.assertAlmostEqual(exponents.fit(x, samples)['exponent'], 1.0, delta=0.02)

    def test_an_exponent_that_is_not_known_is_not_told(self):
        self.assertEqual(tables.exponent({'exponent': 1.0, 'interval': [0.9, 1.1]}), '1.00 (0.90 to 1.10)')
        self.assertEqual(tables.exponent({'exponent': 1.0, 'interval': [0.8, 1.2]}), '–')

    def test_refuses_too_few_measurements(self):
        with self.assertRaises(ValueError):
            exponents.fit([1, 2, 4], repeated([1.0, 2.0, 4.0]))


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

    def test_time_is_asked_in_all_tests_and_of_olson_for_its_windows(self):
        for test in experiments.TESTS:
            slow = row(test=test, matcher='hough', time_ms={'median': 1.6})
            self.assertIn('1.60 ms, more than 1.5', verdicts.time_misses(slow)[0])
            self.assertEqual(verdicts.time_misses(dict(slow, time_ms={'median': 1.4})), [])
            self.assertEqual(verdicts.time_misses(row(test=test, time_ms={'median': 9.0})), [])
        self.assertIn('2.10 ms', verdicts.budget_misses({'name': 'olson-window', 'time_ms': {'median': 2.1}})[0])
        self.assertIn('20.1', verdicts.budget_misses({'name': 'olson-loop', 'time_ms': {'median': 20.1}})[0])
        self.assertEqual(verdicts.budget_misses({'name': 'olson-loop', 'time_ms': {'median': 19.0}}), [])
        self.assertIn('map_bag', verdicts.scan_misses({'matcher': 'hough', 'scan_ms': 2.1})[0])
        self.assertEqual(verdicts.scan_misses({'matcher': 'hough', 'scan_ms': 1.9}), [])

    def test_what_failed_is_no_miss_but_told(self):
        failed = {'test': 'B', 'noise': '1cm', 'matcher': 'olson', 'failed': 'no scans'}
        self.assertEqual(verdicts.accuracy_misses(failed) + verdicts.time_misses(dict(failed, matcher='hough')), [])
        self.assertEqual(verdicts.failures([row(), failed], verdicts.name_of),
                         ['Olson in test B, range noise 1 cm: no scans'])

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


    def test_what_is_found_is_believed_and_near(self):
        # The truth: the robot, which looks along +y, drives 1 m and turns by a whole turn less 0.1 rad.
        heading = 0.5 * math.pi - 0.1
        with tempfile.TemporaryDirectory() as folder:
            truth, pairs = os.path.join(folder, 'truth.tum'), os.path.join(folder, 'pairs.csv')
            write(folder, 'truth.tum', '1.0 5 5 0 0 0 %.9f %.9f\n2.0 5 6 0 0 0 %.9f %.9f\n' % (
                math.sin(0.25 * math.pi), math.cos(0.25 * math.pi), math.sin(0.5 * heading), math.cos(0.5 * heading)))
            row = 'olson,1.0,2.0,1.3,0.4,-0.3,%s,%s,%s\n'
            write(folder, 'pairs.csv', 'matcher,reference_stamp,scan_stamp,guess_x,guess_y,guess_theta,x,y,theta,'
                  'search_x,search_y,search_theta,status\n' +
                  row % ('1.001,0,-0.1', '1.03,0.03,-0.1', 'accepted') + row % ('1.0,0.0,-0.1', '1,0,-0.12', 'accepted') +
                  row % ('1.0,0.0,%.9f' % (2 * math.pi - 0.1), '1,0,-0.1', 'accepted') +
                  row % ('1.0,0.0,-0.1', '1,0,-0.1', 'rejected_low_score') +
                  'hough' + (row % ('9,0,0', '9,0,0', 'accepted'))[5:])
            read = pair_errors.read_pairs(pairs, truth, 'olson')
        self.assertEqual(len(read), 4)
        self.assertAlmostEqual(read[0].guess[0], 0.5, places=6)
        self.assertAlmostEqual(read[0].guess[1], 0.2, places=6)
        self.assertAlmostEqual(read[2].answer[1], 0.0, places=6)
        found = pair_errors.found_shares(read, (0.05, 0.01))
        self.assertEqual(found, {'search': 0.5, 'answer': 0.75})
        self.assertEqual([round(value, 3) for value in pair_errors.median(read, 'answer')], [0.0, 0.0])
        self.assertEqual(pair_errors.found_by_guess(read, (0.05, 0.01), 1.6, 4), [None, found, None, None])
        self.assertEqual(pair_errors.found_by_guess(read, (0.05, 0.01), 0.5, 2), [None, found])


class CompareTest(unittest.TestCase):

    def test_names_what_differs(self):
        first = {'a': [1, {'b': 2}], 'c': 'x'}
        self.assertEqual(compare.differences(first, copy.deepcopy(first)), [])
        self.assertEqual(compare.differences(first, {'a': [1, {'b': 3}], 'c': 'x'}), ['/a/1/b: 2, 3'])
        self.assertEqual(compare.differences(first, {'a': [1, {'b': 2}]}), ['/c: "x", null'])


class ExperimentsTest(unittest.TestCase):

    def test_a_quick_run_measures_all_points_in_bags_that_it_simulates(self):
        bags = experiments.simulated_bags(experiments.SIZES['quick'])
        for complexity in experiments.COMPLEXITIES.values():
            self.assertGreaterEqual(len(complexity.points), 5)
            for _, beams, _ in complexity.points:
                self.assertIn('beams-%d' % beams, bags)
        self.assertIn(experiments.BUDGET_BAG, bags)
        for kind, names in (('searches', experiments.SEARCHES), ('basins', experiments.BASINS),
                            ('hard', experiments.HARD)):
            for name in names:
                self.assertIn(experiments.bag_together(kind, name), bags)

    def test_a_quick_run_caps_a_given_bag(self):
        entry = {'bag': ['/a.bag']}
        self.assertEqual(experiments.recording(entry, duration=60).map_options, ['--duration', '60'])
        self.assertEqual(experiments.recording(dict(entry, map_options='--duration=5'), duration=60).map_options,
                         ['--duration=5'])
        self.assertEqual(experiments.recording(entry).map_options, [])

    def test_what_the_workflow_sets_is_refused(self):
        for options in ('--set matcher=hough', '--set=seed=3', '--matcher hough', '--seed=3', '--out x', '--set "'):
            with self.assertRaises(experiments.Mistake):
                experiments.check_map_options(options, 'x')
        experiments.check_map_options('--scan-topic /a --set map/resolution=0.1 --set olson/step_xy=0.1', 'x')
        with self.assertRaises(experiments.Mistake):
            experiments.check_settings({'seed': 3}, 'x')

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


class MapsTest(unittest.TestCase):

    def test_a_wall_of_one_cell_stays_black_when_the_map_shrinks(self):
        # 100 m at 5 cm: a room of free cells whose walls are one cell thick.
        cells = numpy.full((2000, 2000), draw_maps.UNKNOWN)
        cells[101:1900, 101:1900] = draw_maps.FREE
        cells[101:1900, [101, 1000]] = draw_maps.OCCUPIED
        cells[[101, 1899], 101:1900] = draw_maps.OCCUPIED
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'map.png')
            draw_maps.draw_map(cells, (-50.0, -50.0), 0.05, (-50.0, 50.0, -50.0, 50.0), path)
            picture = draw_maps.pyplot.imread(path)[..., :3]
        # The part within the axes, which the background of the figure surrounds.
        middle = picture[picture.shape[0] // 3]
        black = numpy.flatnonzero((middle < 0.1).all(axis=1))
        grey = numpy.flatnonzero((abs(middle - draw_maps.to_rgb(draw_maps.COLORS[draw_maps.UNKNOWN])) < 0.01).all(axis=1))
        width = grey.max() - grey.min()
        for share in (0.05, 0.5):  # the left wall, the one in the middle
            self.assertLess(abs(black - (grey.min() + (share + 0.0003) * width)).min(), 3, share)

    def test_shrinking_ranks_walls_before_free_before_unknown(self):
        cells = numpy.array([[2, 1, 2], [1, 0, 2], [2, 2, 1]])
        numpy.testing.assert_array_equal(draw_maps.shrink(cells, 2), [[0, 2], [2, 1]])
        numpy.testing.assert_array_equal(draw_maps.shrink(cells, 1), cells)


class CommitTest(unittest.TestCase):

    def commit_of(self, source):
        header = os.path.join(source, '..', 'commit.hpp')
        done = run('cmake', '-DSOURCE=' + source, '-DHEADER=' + header, '-P',
                   os.path.join(SOURCE, 'cmake', 'write_commit.cmake'))
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(header) as file:
            return file.read().split('"')[1]

    def git(self, folder, *words):
        done = run('git', '-C', folder, '-c', 'user.name=a', '-c', 'user.email=a@b', *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.strip()

    def test_tells_the_commit_of_the_sources_and_of_nothing_around_them(self):
        with tempfile.TemporaryDirectory() as folder:
            source = os.path.join(folder, 'outer', 'source')
            os.makedirs(source)
            package = os.path.join(source, 'package.xml')
            shutil.copy(os.path.join(SOURCE, 'package.xml'), package)
            self.assertEqual(self.commit_of(source), 'unknown')
            # A copy below someone else's repository is not of their commit.
            outer = os.path.dirname(source)
            self.git(outer, 'init', '-q')
            self.git(outer, 'add', '.')
            self.git(outer, 'commit', '-qm', 'theirs')
            self.assertEqual(self.commit_of(source), 'unknown')
            self.git(source, 'init', '-q')
            self.git(source, 'add', '.')
            self.git(source, 'commit', '-qm', 'ours')
            commit = self.git(source, 'rev-parse', '--short=7', 'HEAD')
            self.assertEqual(self.commit_of(source), commit)
            # Also where the package is a folder of links.
            links = os.path.join(folder, 'links', 'package')
            os.makedirs(links)
            os.symlink(package, os.path.join(links, 'package.xml'))
            self.assertEqual(self.commit_of(links), commit)
            with open(package, 'a') as file:
                file.write('\n')
            self.assertEqual(self.commit_of(source), commit + '-dirty')


PAIRS = {'matcher': 'olson', 'pairs': 3, 'success_rate': 1.0, 'configuration': {'map/resolution': 0.05},
         'translation_mm': {'median': 0.5, 'p95': 1.0, 'max': 2.0},
         'heading_mrad': {'median': 0.1, 'p95': 0.2, 'max': 0.3}, 'time_ms': {'median': 1.0, 'p95': 2.0, 'max': 3.0},
         'search': {'success_rate': 0.875, 'translation_mm': {'median': 11.5}, 'heading_mrad': {'median': 2.25}}}
MACHINE = {'host': 'a', 'cpu': 'fast', 'cores': 2}


class ResultsTest(unittest.TestCase):

    def test_short_names_are_those_of_the_package(self):
        for name, short in (('matchbox_slam/MonteCarlo', 'monte_carlo'), ('a/ICPMatcher', 'icp_matcher'),
                            ('OdometryOnly', 'odometry_only'), ('olson', 'olson')):
            self.assertEqual(results.short_name(name), short)

    def test_a_report_has_to_be_of_its_cell(self):
        with tempfile.TemporaryDirectory() as folder:
            write(folder, 'summary.json', {'seed': 1, 'matchers': [PAIRS]})
            write(folder, 'pairs.csv', '')
            self.assertEqual(results.result_of_pairs(folder, 'olson', 1)[1]['pairs'], 3)
            for matcher, seed in (('hough', 1), ('olson', 2)):
                with self.assertRaisesRegex(files.Failed, 'of olson with seed 1'):
                    results.result_of_pairs(folder, matcher, seed)

    def test_the_last_word_of_a_log_is_the_reason(self):
        with tempfile.TemporaryDirectory() as folder:
            log = os.path.join(folder, 'log')
            self.assertIn('not made', files.reason(log))
            write(folder, 'log', '+ map_bag a.bag\n')
            self.assertIn('ended from outside', files.reason(log))
            write(folder, 'log', '+ map_bag a.bag\nmap_bag: a warning\nmap_bag: no scans\n\n')
            self.assertEqual(files.reason(log), 'map_bag: no scans')
            with self.assertRaisesRegex(files.Failed, 'no scans'):
                files.require([os.path.join(folder, 'report.json')], log)


@unittest.skipIf(not hasattr(matplotlib.figure.Figure, 'get_layout_engine'),
                 'THE PAGE IS NOT TESTED: it needs matplotlib 3.6, and here is ' + matplotlib.__version__)
class PageTest(unittest.TestCase):
    """From what the programs wrote to the page; one cell has results, the others none."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        folder = cls.folder.name
        summary = {'seed': 1, 'matchers': [PAIRS], 'beams': 1040, 'gap_s': 0.5, 'success_xy_m': 0.02,
                   'success_theta_rad': 0.01, 'reach_m': 10.0, 'commit': 'c0ffee1', 'version': '1.2.3',
                   'date': '2024-02-29', 'machine': MACHINE}
        write(folder, 'bags/rooms-1cm.tum', '1.0 0 0 0 0 0 0 1\n2.0 1 0 0 0 0 0 1\n')
        pairs = 'reference_stamp,scan_stamp,x,y,time_us\n' + '1.000000,2.000000,1.001,0.002,1000\n' * 3
        cells = ['pairs/B/1cm/olson'] + ['complexity/olson-beams/%d' % beams for beams in experiments.BEAMS]
        for number, cell in enumerate(cells):
            write(folder, cell + '/summary.json', summary)
            write(folder, cell + '/pairs.csv', pairs.replace('1000\n', '%d\n' % (1000 * 2 ** number)))
            write(folder, cell + '/match_pairs.log', '+ /somewhere/match_pairs %s\n' % cell)
        # Of the jobs in which all matchers match, one of each kind; of the guesses one in three is near.
        together = ('matcher,reference_stamp,scan_stamp,guess_x,guess_y,guess_theta,x,y,theta,search_x,search_y,'
                    'search_theta,status\n')
        for guess, search in ((1.05, 1.01), (1.95, 1.02), (1.95, 1.4)):
            together += 'olson,1.0,2.0,%s,0,0,1.001,0,0.001,%s,0,0.002,accepted\n' % (guess, search)
        write(folder, 'bags/hard-random-181-5cm-40.tum', '1.0 0 0 0 0 0 0 1\n2.0 1 0 0 0 0 0 1\n')
        for cell in ('searches/B', 'basins/rooms-wide', 'hard/random-181-5cm-40'):
            write(folder, cell + '/summary.json', summary)
            write(folder, cell + '/pairs.csv', together)
        write(folder, 'pairs/B/1cm/hough/match_pairs.log', '+ /x/match_pairs\nmatch_pairs: <out> of memory\n')
        options = {'size': 'quick', 'seed': 1, 'has_truth': False, 'bags': ['a<b.bag'], 'settings': {}}
        os.mkdir(os.path.join(folder, 'figures'))
        for words in (['collect.py', '--options', json.dumps(options), '--programs', '{"map_bag": "f00"}'],
                      ['draw_complexity.py'], ['draw_basins.py'], ['page.py']):
            done = subprocess.run([sys.executable, os.path.join(WORKFLOW, words[0])] + words[1:], cwd=folder,
                                  stderr=subprocess.PIPE, text=True)
            assert done.returncode == 0, done.stderr
        cls.text = {name: read_text(folder, name)
                    for name in ('index.html', 'tables.md', 'summary.json', 'times.json')}

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_needs_no_other_file(self):
        for address in re.findall(r'(?:src|href)\s*=\s*"([^"]*)"|url\(([^)]*)\)', self.text['index.html']):
            self.assertTrue(''.join(address).startswith('data:'), address)
        self.assertIn('src="data:image/png;base64,', self.text['index.html'])

    def test_escapes_names(self):
        self.assertIn('a&lt;b.bag', self.text['index.html'])
        self.assertNotIn('a<b', self.text['index.html'])

    def test_tells_who_measured_what(self):
        self.assertIn('commit c0ffee1', self.text['index.html'])
        self.assertIn('a (fast, 2 cores) on 2024-02-29', self.text['index.html'])
        self.assertIn('pairs of scans 0.5 s apart, 1040 beams', self.text['index.html'])
        self.assertIn('within 2 cm and 10 mrad', self.text['index.html'])
        self.assertIn('A quick run', self.text['index.html'])
        self.assertIn('match_pairs pairs/B/1cm/olson', self.text['index.html'])

    def test_shows_results_and_failures(self):
        for name, reason in (('index.html', '&lt;out&gt; of memory'), ('tables.md', '<out> of memory')):
            self.assertIn('failed: match_pairs: ' + reason, self.text[name])
            self.assertIn('failed: not made', self.text[name])
        self.assertIn('| Olson, noise 1 cm | 1.000 | 2.000 | 3.000 | 1.000 | 2.000 | 0.50 | 1.00 | 0.100 | 0.200 | 100.0 | '
                      '11.50 | 2.250 | 87.5 |', self.text['tables.md'])
        self.assertIn('1.00 (1.00 to 1.00)', self.text['tables.md'])

    def test_shows_searches_alone_beside_refined_answers(self):
        for row in ('| Olson, test B | 1.000 | 2.000 | 1.000 | 2.000 |',
                    '| straight world, told ±1 m and ±45°: Olson | 100 / 100 |' + ' – |' * 8 + ' 50 / 100 | 1.00 |',
                    '| random, 181 beams, noise 5 cm, outliers 40 %: Olson | 67 / 100 | 20.0 / 1.00 | 2.00 / 1.000 | 1.00 |'):
            self.assertIn(row, self.text['tables.md'])
        self.assertIn('within 5 cm and 0.5° of the truth', self.text['index.html'])
        self.assertIn('alt="Success against the error of the guess', self.text['index.html'])

    def test_nothing_missing_is_rounded_away(self):
        self.assertEqual(tables.found_cell({'search': 0.9999, 'answer': 1.0}), '99 / 100')
        self.assertEqual(tables.found_cell(None), '–')

    def test_what_depends_on_the_machine_is_not_in_the_summary(self):
        for word in ('f00', '2024-02-29', 'fast', 'match_pairs pairs/', '"time_ms"'):
            self.assertNotIn(word, self.text['summary.json'])
            self.assertIn(word, self.text['times.json'])


if __name__ == '__main__':
    unittest.main()
