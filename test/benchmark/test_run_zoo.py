"""benchmark/run_zoo.py: which drives it has, what it makes of results, that it goes on where it ended; and a dozen drives."""

import itertools
import json
import os
import pathlib
import stat
import subprocess
import sys
import time
import unittest

import rosbag
import rospy
from sensor_msgs.msg import LaserScan

from program_test import BENCHMARK, ProgramTest

sys.path.insert(0, BENCHMARK)

import zoo_drives  # noqa: E402
import zoo_report  # noqa: E402

PROGRAMS = os.environ.get('MATCHBOX_PROGRAMS')

# In place of the package's programs: each writes down that it ran. map_bag knows neither `hypotheses/enabled` nor drives through glass.
SIMULATE = '''#!PYTHON -SE
import sys
words = sys.argv[1:]
open(words[words.index("--bag") + 1], "w").write(" ".join(words))
open(words[words.index("--truth") + 1], "w").write("")
open(LOG, "a").write("simulate\\n")
'''
MAP_BAG = '''#!PYTHON -SE
import json, os, sys
words = sys.argv[1:]
bag, out = open(words[0], errors="replace").read(), words[words.index("--out") + 1]
open(LOG, "a").write("map_bag " + " ".join(words[1:]) + "\\n")
if "hypotheses/enabled=false" in words:
    sys.exit("map_bag: hypotheses/enabled: there is no such option")
if "--world glass" in bag:
    sys.exit("map_bag: broken")
os.makedirs(out, exist_ok=True)
open(out + "/scans.csv", "w").write("stamp,state\\n1,tracking\\n2,lost\\n3,doubt\\n4,recovered\\n")
open(out + "/report.json", "w").write(json.dumps({"cpu_s": 0.02}))
error = 0.1 if "slam/loop_closing=false" in words else 0.2
for name, text in (("trajectory", str(error)), ("odometry", "3")):
    open(out + "/" + name + ".tum", "w").write(text)
'''
EVALUATE = '''#!PYTHON -SE
import json, sys
print(json.dumps({"estimates": [{"estimate": name, "rmse_m": float(open(name).read())}
                                for name in sys.argv[1:] if name.endswith(("trajectory.tum", "odometry.tum"))]}))
'''


def run_of(ate, unsure=0.0, **more):
    return {'ate_m': ate, 'odometry_m': 1.0, 'lost': 0.0, 'unsure': unsure, 'cpu_ms': 1.0, 'scans': 100, **more}


def drive_of(name, kinds, runs, floor=0.0, has_truth=True):
    return {'name': name, 'kinds': kinds, 'floor_m': floor, 'has_truth': has_truth, 'commands': ['simulate ' + name],
            'runs': runs}


def zoo_of(drives, mechanisms=('loops', 'hypotheses')):
    return {'commit': 'abc', 'date': '2026-01-01', 'mechanisms': {name: [name + '=false'] for name in mechanisms},
            'drives': drives}


HAND_MADE = [
    drive_of('a', {'world': 'rooms', 'fault': 'none'},
             {'default': run_of(0.4, 0.5), '-loops': run_of(0.1), '-hypotheses': run_of(0.8), '+loops': run_of(0.2), 'none': run_of(0.1)}),
    drive_of('b', {'world': 'rooms', 'fault': 'freeze'},
             {'default': run_of(0.0001), '-loops': run_of(0.0009), '-hypotheses': run_of(0.004), '+loops': run_of(0.01),
              'none': run_of(0.1)}),
    drive_of('c', {'world': 'hall', 'fault': 'none'}, {'default': {'failed': 'no scan'}, '-loops': run_of(0.1)}),
    drive_of('d', {'recording': 'aces', 'thinning': 'whole'},
             {'default': run_of(0.05), '-loops': run_of(0.2), '-hypotheses': run_of(0.09)}, floor=0.1),
    drive_of('e', {'recording': 'guardian', 'thinning': 'whole'},
             {'default': {'lost': 0.25, 'unsure': 0.25, 'cpu_ms': 2.0, 'scans': 8}}, has_truth=False),
]


class Drives(unittest.TestCase):
    def test_all_pairs_that_are_allowed_occur_and_no_others(self):
        rows = [tuple(drive.kinds.items()) for drive in zoo_drives.all_drives()]
        there = set(itertools.chain.from_iterable(map(zoo_drives.pairs_of, rows)))
        allowed = set(zoo_drives.allowed_pairs(zoo_drives.FACTORS))
        self.assertEqual(there, allowed)
        self.assertGreater(len(allowed), 400)
        self.assertNotIn((('odometry', 'none'), ('fault', 'freeze')), allowed)

    def test_they_are_many_and_few_are_of_a_fault(self):
        drives = zoo_drives.all_drives()
        self.assertEqual(len(drives), zoo_drives.DRIVES)
        without = sum(drive.kinds['fault'] == 'none' for drive in drives)
        self.assertGreater(without, len(drives) // 2)

    def test_they_are_the_same_each_time_and_each_another(self):
        first, second = ([(drive.name, drive.simulate_options()) for drive in zoo_drives.all_drives()] for _ in range(2))
        self.assertEqual(first, second)
        program = 'import zoo_drives; print([(d.name, d.simulate_options()) for d in zoo_drives.all_drives()])'
        other = subprocess.run([sys.executable, '-c', program], cwd=BENCHMARK, capture_output=True, text=True,
                               env={**os.environ, 'PYTHONHASHSEED': '7'})
        self.assertEqual(other.stdout.strip(), str(first), other.stderr)
        self.assertEqual(len({name for name, _ in first}), len(first))
        self.assertEqual(len({drive.seed for drive in zoo_drives.all_drives()}), len(first))

    def test_others_are_none_of_these_and_have_all_pairs_too(self):
        known = {drive.name for drive in zoo_drives.all_drives()}
        one, two = ([drive.name for drive in zoo_drives.all_drives(number)] for number in (1, 2))
        self.assertFalse(known & set(one))
        self.assertNotEqual(one, two)
        self.assertEqual(one, [drive.name for drive in zoo_drives.all_drives(1)])
        self.assertGreater(len(one), 0.9 * zoo_drives.DRIVES)
        rows = [tuple(drive.kinds.items()) for drive in zoo_drives.all_drives(1)]
        there = set(itertools.chain.from_iterable(map(zoo_drives.pairs_of, rows)))
        self.assertGreater(len(there), 0.95 * len(zoo_drives.allowed_pairs(zoo_drives.FACTORS)))

    def test_unseen_ones_are_of_other_worlds_and_have_all_pairs(self):
        self.assertFalse(set(zoo_drives.UNSEEN_WORLDS) & set(zoo_drives.WORLDS))
        factors = {**zoo_drives.FACTORS, 'world': zoo_drives.UNSEEN_WORLDS}
        first, one = (zoo_drives.unseen_drives(number) for number in (None, 1))
        self.assertFalse({drive.name for drive in first} & {drive.name for drive in one})
        allowed = set(zoo_drives.allowed_pairs(factors))
        for drives, least in ((first, 1.0), (one, 0.95)):
            rows = [tuple(drive.kinds.items()) for drive in drives]
            there = set(itertools.chain.from_iterable(map(zoo_drives.pairs_of, rows)))
            self.assertFalse(there - allowed)
            self.assertGreaterEqual(len(there), least * len(allowed))
        self.assertEqual({drive.kinds['world'] for drive in zoo_drives.quick_drives(first)}, set(zoo_drives.UNSEEN_WORLDS))

    def test_scans_lie_as_far_apart_as_said(self):
        for drive in zoo_drives.all_drives() + zoo_drives.unseen_drives():
            options = drive.simulate_options()
            speed, rate = (float(options[options.index(name) + 1]) for name in ('--speed', '--scan-rate'))
            self.assertAlmostEqual(speed / rate, drive.kinds['distance'], 3)
            self.assertLessEqual(rate, zoo_drives.SWEEPS.get(drive.kinds['sensor'], 100.0) + 0.01)

    def test_a_dozen_have_each_value(self):
        quick = zoo_drives.quick_drives(zoo_drives.all_drives())
        self.assertEqual(len(quick), 12)
        for name, values in zoo_drives.FACTORS.items():
            self.assertEqual({drive.kinds[name] for drive in quick}, set(values))


class Report(unittest.TestCase):
    def row(self, lines, begin):
        rows = [line for line in lines if line.startswith('| ' + begin + ' |')]
        self.assertEqual(len(rows), 1, lines)
        return [cell.strip() for cell in rows[0].strip('|').split('|')]

    def test_the_default_by_kind(self):
        lines = zoo_report.default_table(HAND_MADE)
        # 0.4 and, of a millimetre at least, 0.001
        self.assertEqual(self.row(lines, 'world rooms'),
                         ['world rooms', '2', '0.0200', '0.400', '1.000', '0.0 %', '25.0 %', '1.00'])
        self.assertEqual(self.row(lines, 'world hall')[1:4], ['1, 1 failed', '–', '–'])
        self.assertEqual(self.row(lines, 'recording aces')[2], '0.1000')
        self.assertEqual(self.row(lines, 'recording guardian'),
                         ['recording guardian', '1', '–', '–', '–', '25.0 %', '25.0 %', '2.00'])
        self.assertEqual(self.row(lines, 'all simulated')[1], '3, 1 failed')

    def test_what_a_mechanism_is_worth(self):
        lines = zoo_report.worth_table(HAND_MADE, ['loops', 'hypotheses'])
        # loops: 4 and 1, hypotheses: 0.5 and 0.25; the best with one left out: 4 and 1
        self.assertEqual(self.row(lines, 'world rooms')[1:], ['2.00', '0.35', '2.00'])
        self.assertEqual(self.row(lines, 'fault none')[1:], ['4.00', '0.50', '4.00'])
        self.assertEqual(self.row(lines, 'recording aces')[1:], ['0.50', '1.00', '1.00'])
        self.assertFalse(any('guardian' in line for line in lines))
        lines = zoo_report.alone_table(HAND_MADE, ['loops', 'hypotheses'])
        self.assertEqual(self.row(lines, 'fault freeze')[1:], ['0.01', '0.10', '–'])

    def test_the_whole_names_truths_commands_and_failures(self):
        page = zoo_report.report(zoo_of(HAND_MADE), ['# The zoo'])
        for words in ('aces 0.1', 'particle filter', 'without truth, for shares and time alone: guardian', 'simulate a',
                      'c, default: no scan', '- hypotheses: off by `hypotheses=false`'):
            self.assertIn(words, page)
        self.assertLess(page.index('| a | 0.400'), page.index('| b | 0.000'))

    def test_the_page_tells_the_worst_first_and_keeps_what_is_around(self):
        drives = HAND_MADE + [drive_of('f', {'world': 'hall', 'fault': 'none'},
                                       {'default': run_of(0.1), '-loops': run_of(0.1), '-hypotheses': run_of(0.05)})]
        section = zoo_report.page_section(zoo_of(drives))
        loops, hypotheses = (section.index(f'| `{name}`') for name in ('loops', 'hypotheses'))
        self.assertLess(loops, hypotheses)
        self.assertIn('fault none 2.00', section[loops:hypotheses])
        page = zoo_report.with_section('before\n' + zoo_report.BEGIN + 'old\n' + zoo_report.END + 'after\n', section)
        self.assertEqual(page, 'before\n' + zoo_report.BEGIN + '\n' + section + '\n' + zoo_report.END + 'after\n')
        with self.assertRaises(SystemExit):
            zoo_report.with_section('no markers\n', section)

    def test_then_and_now(self):
        now = [drive_of('a', {'world': 'rooms'}, {'default': run_of(0.1, 0.0, cpu_ms=0.5)}),
               drive_of('new', {'world': 'rooms'}, {'default': run_of(9.0)})]
        lines = zoo_report.comparison(zoo_of(HAND_MADE), zoo_of(now)).splitlines()
        self.assertEqual(self.row(lines, 'world rooms'),
                         ['world rooms', '1', '0.4000', '0.1000', '0.25', '0.400', '0.100', '50.0 %', '0.0 %', '0.50'])


class Program(ProgramTest):
    program = 'run_zoo.py'

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.space = pathlib.Path(cls.path('space'))
        programs = cls.space / 'lib' / 'matchbox_slam'
        programs.mkdir(parents=True)
        cls.log = pathlib.Path(cls.path('log'))
        for name, text in (('simulate', SIMULATE), ('map_bag', MAP_BAG), ('evaluate', EVALUATE)):
            file = programs / name
            file.write_text(text.replace('PYTHON', sys.executable).replace('LOG', repr(str(cls.log))))
            file.chmod(file.stat().st_mode | stat.S_IXUSR)

    def setUp(self):
        self.log.write_text('')

    def ran(self, program):
        return [line for line in self.log.read_text().splitlines() if line.startswith(program)]

    def zoo(self, out, *arguments):
        return self.run_on('--out', out, '--bin', str(self.space), '--no-recordings', *arguments)

    def test_each_mechanism_is_left_out_and_alone_and_what_is_not_known_is_told_once(self):
        out = self.path('mechanisms')
        done = self.zoo(out, '--only-world', 'rooms', '--only', '^rooms-utm30-perfect-0.03-none')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr.count('hypotheses is left out'), 1, done.stderr)
        self.assertIn('there is no such option', done.stderr)
        zoo = json.loads(pathlib.Path(out, 'zoo.json').read_text())
        self.assertEqual(done.stderr.count('is left out'), 1, done.stderr)
        self.assertNotIn('hypotheses', zoo['mechanisms'])
        self.assertIn('loops', zoo['mechanisms'])
        drive = zoo['drives'][0]
        names = {'default', 'none'} | {sign + name for name in zoo['mechanisms'] for sign in '-+'}
        self.assertEqual(set(drive['runs']), names)
        self.assertEqual(drive['runs']['default'], {'ate_m': 0.2, 'odometry_m': 3.0, 'scans': 4, 'cpu_ms': 5.0, 'lost': 0.25,
                                                    'unsure': 0.5})
        self.assertEqual(drive['runs']['-loops']['ate_m'], 0.1)
        self.assertEqual(drive['runs']['+share']['ate_m'], 0.1)
        self.assertEqual(drive['runs']['+loops']['ate_m'], 0.2)
        self.assertIn('÷ without loops', pathlib.Path(out, 'ZOO.md').read_text())

    def test_recordings_are_thinned_and_have_a_floor(self):
        data, out = self.path('data'), self.path('recordings')
        os.mkdir(data)
        with rosbag.Bag(os.path.join(data, 'aces.bag'), 'w') as bag:
            for k in range(8):
                bag.write('/base_scan', LaserScan(header=rospy.Header(stamp=rospy.Time(k + 1)), ranges=[1.0] * 8))
        done = self.run_on('--out', out, '--bin', str(self.space), '--data', data, '--only', '^aces')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn('left out: jarvis_circular', done.stderr)
        drives = {drive['kinds']['thinning']: drive for drive in json.loads(pathlib.Path(out, 'zoo.json').read_text())['drives']}
        self.assertEqual(len(drives), 6)
        self.assertEqual(drives['whole']['floor_m'], 0.1)
        self.assertIn('+loops', drives['every 4th scan']['runs'])
        self.assertIn('-loops', drives['every 2nd scan']['runs'])
        self.assertNotIn('+loops', drives['every 2nd scan']['runs'])
        self.assertIn('map_bag aces.bag --set scan/max_range=8 --out out', drives['reach 8 m']['commands'])
        self.assertIn('benchmark/thin_bag.py aces.bag drive.bag --scans 1 --beams 4', drives['every 4th beam']['commands'])
        for name, scans, beams in (('every_4th_scan', 2, 8), ('every_2nd_beam', 8, 4)):
            with rosbag.Bag(os.path.join(out, 'bags', f'aces_{name}.bag')) as bag:
                left = [message for _, message, _ in bag.read_messages()]
            self.assertEqual((len(left), len(left[0].ranges)), (scans, beams))

    def test_what_was_run_is_not_run_again(self):
        out = self.path('resumed')
        arguments = (out, '--no-mechanisms', '--leave-out', 'glass')
        done = self.zoo(*arguments, '--only', 'utm30')
        self.assertEqual(done.returncode, 0, done.stderr)
        first = len(self.ran('map_bag'))
        self.assertEqual(len(self.ran('simulate')), first)
        self.assertGreater(first, 5)
        with open(os.path.join(out, 'runs.jsonl'), 'a') as file:
            file.write('["cut o')  # as of a run that was killed
        self.log.write_text('')
        done = self.zoo(*arguments, '--only', 'utm30|ranger32-perfect')
        self.assertEqual(done.returncode, 0, done.stderr)
        zoo = json.loads(pathlib.Path(out, 'zoo.json').read_text())
        self.assertEqual(len(self.ran('map_bag')), len(zoo['drives']) - first)
        self.assertTrue(all('ranger32' in drive['name'] or 'utm30' in drive['name'] for drive in zoo['drives']))
        self.assertTrue(all('default' in drive['runs'] for drive in zoo['drives']))
        self.log.write_text('')
        self.zoo(*arguments, '--only', 'utm30', '--set', 'slam/loop_closing=false')  # is another run of the same bags
        self.assertEqual((len(self.ran('simulate')), len(self.ran('map_bag'))), (0, first))
        program = self.space / 'lib' / 'matchbox_slam' / 'map_bag'
        before = program.read_text()
        try:
            program.write_text(before + '# another build\n')
            self.log.write_text('')
            self.zoo(*arguments, '--only', 'utm30', '--drop-bags')
            self.assertEqual((len(self.ran('simulate')), len(self.ran('map_bag'))), (0, first))
            self.assertFalse(os.path.exists(os.path.join(out, 'bags')))
        finally:
            program.write_text(before)

    def test_what_was_run_when_it_is_ended_is_in_the_report(self):
        out = self.path('ended')
        command = [sys.executable, os.path.join(BENCHMARK, self.program), '--out', out, '--bin', str(self.space),
                   '--no-recordings', '--leave-out', 'glass', '--no-mechanisms']
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while len(self.ran('map_bag')) < 5 and process.poll() is None:
            time.sleep(0.01)
        process.terminate()
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, errors)
        self.assertIn('interrupted: the report is of what was run', errors)
        zoo = json.loads(pathlib.Path(out, 'zoo.json').read_text())
        ran = sum(bool(drive['runs']) for drive in zoo['drives'])
        self.assertGreaterEqual(ran, 3)
        self.assertLess(ran, len(zoo['drives']))
        self.assertIn('| all simulated |', pathlib.Path(out, 'ZOO.md').read_text())

    def test_one_run_that_fails_ends_nothing(self):
        out = self.path('failed')
        for _ in range(2):  # and is tried again
            self.log.write_text('')
            done = self.zoo(out, '--no-mechanisms', '--only', 'sick180')
            self.assertEqual(done.returncode, 1)
            self.assertIn('map_bag: broken', done.stderr)
            self.assertGreater(len(self.ran('map_bag')), 0)
        zoo = json.loads(pathlib.Path(out, 'zoo.json').read_text())
        for drive in zoo['drives']:
            self.assertEqual('failed' in drive['runs']['default'], drive['kinds']['world'] == 'glass', drive)
        self.assertIn('## Failed', pathlib.Path(out, 'ZOO.md').read_text())

    def test_a_file_of_results_makes_page_and_comparison_anew(self):
        old, page = self.path('old.json'), self.path('page.md')
        for path, drives in ((old, HAND_MADE), (self.path('new.json'), HAND_MADE[:2])):
            with open(path, 'w') as file:
                json.dump(zoo_of(drives), file)
        with open(page, 'w') as file:
            file.write(zoo_report.BEGIN + zoo_report.END)
        done = self.run_on('--from', self.path('new.json'), '--compare', old, '--page', page)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn('now ÷ before', done.stdout)
        with open(page) as file:
            self.assertIn('| `loops` | 2.00 |', file.read())
        self.assertEqual(self.ran('map_bag'), [])

    @unittest.skipUnless(PROGRAMS, 'MATCHBOX_PROGRAMS does not say where the programs are')
    def test_a_dozen_drives(self):
        out, begin = self.path('quick'), time.monotonic()
        space = os.path.dirname(os.path.dirname(os.path.normpath(PROGRAMS)))
        done = subprocess.run([sys.executable, os.path.join(BENCHMARK, self.program), '--out', out, '--bin', space, '--quick'],
                              capture_output=True, text=True, timeout=600)
        self.assertEqual(done.returncode, 0, done.stderr)
        zoo = json.loads(pathlib.Path(out, 'zoo.json').read_text())
        self.assertEqual(len(zoo['drives']), 12)
        for drive in zoo['drives']:
            run = drive['runs']['default']
            self.assertGreater(run['scans'], 20, drive)
            self.assertGreaterEqual(run['ate_m'], 0.0, drive)
        print(f'{time.monotonic() - begin:.0f} s')


if __name__ == '__main__':
    unittest.main()
