"""benchmark/wall_distance.py: what it measures, and that a mistake ends it with one line that says what to do."""

import json
import unittest

import rosbag
import rospy
from sensor_msgs.msg import LaserScan

from program_test import ProgramTest

SCANS = 120


def scan(stamp):
    """A wall 2 m ahead."""
    return LaserScan(header=rospy.Header(stamp=rospy.Time.from_sec(stamp)), angle_min=-0.2, angle_increment=0.01,
                     range_max=10.0, ranges=[2.0] * 41)


class WallDistance(ProgramTest):
    program = 'wall_distance.py'

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        with rosbag.Bag(cls.path('run.bag'), 'w') as bag:
            for k in range(SCANS):
                bag.write('/base_scan', scan(100.0 + k))
        for name, shift in (('still.tum', 0.0), ('drifts.tum', 0.001)):
            with open(cls.path(name), 'w') as file:
                for k in range(SCANS):
                    file.write(f'{100.0 + k:.6f} {shift * k:.6f} 0 0 0 0 0 1\n')

    def test_a_wall_that_drifts_is_not_where_it_was(self):
        done = self.run_on(self.path('run.bag'), '--scan', '/base_scan', '--apart', '40',
                           self.path('still.tum'), self.path('drifts.tum'))
        self.assertEqual(done.returncode, 0, done.stderr)
        still, drifts = (json.loads(line) for line in done.stdout.splitlines())
        self.assertEqual((still['scans'], still['mean_m'], still['alone']), (SCANS, 0.0, 0))
        self.assertGreater(drifts['mean_m'], 0.005)

    def test_a_mistake_is_told_in_one_line(self):
        bag, still = self.path('run.bag'), self.path('still.tum')
        for name, text in (('words.tum', 'no numbers\n'), ('few.tum', '1 2 3\n'), ('none.tum', ''),
                           ('nan.tum', '100 nan 0 0 0 0 0 1\n'), ('elsewhere.tum', '7 0 0 0 0 0 0 1\n')):
            with open(self.path(name), 'w') as file:
                file.write(text)
        with open(bag, 'rb') as file:
            whole = file.read()
        with open(self.path('cut.bag'), 'wb') as file:
            file.write(whole[:len(whole) // 2])
        for arguments, words in (
                ((bag, still), "--scan: '/scan' is no topic of sensor_msgs/LaserScan in "),
                ((bag, still), 'there: /base_scan'),
                ((self.path('no.bag'), still), 'cannot be read: No such file or directory'),
                ((self.folder.name, still), 'cannot be read: Is a directory'),
                ((still, still), 'cannot be read: '),
                ((self.path('cut.bag'), still), 'rosbag reindex'),
                ((bag, '--scan', '/base_scan', self.path('no.tum')), 'cannot be read: No such file or directory'),
                ((bag, '--scan', '/base_scan', self.folder.name), 'cannot be read: Is a directory'),
                ((bag, '--scan', '/base_scan', bag), 'is no TUM file'),
                ((bag, '--scan', '/base_scan', self.path('words.tum')), 'is no TUM file'),
                ((bag, '--scan', '/base_scan', self.path('few.tum')), 'is no TUM file'),
                ((bag, '--scan', '/base_scan', self.path('none.tum')), 'is no TUM file'),
                ((bag, '--scan', '/base_scan', self.path('nan.tum')), 'is no TUM file'),
                ((bag, '--scan', '/base_scan', self.path('elsewhere.tum')), 'stamps have to agree'),
                ((bag, '--scan', '/base_scan', still, '--apart', '1000'), 'the robot did not come by again')):
            done = self.run_on(*arguments)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(words, done.stderr)
            self.assertEqual(done.stderr.count('\n'), 1, done.stderr)
        for option, value in (('--reach', '0'), ('--apart', '-3'), ('--mount', 'nan')):
            done = self.run_on(bag, '--scan', '/base_scan', still, option, value, *['0'] * 2 * (option == '--mount'))
            self.assertEqual(done.returncode, 2)
            self.assertIn(f'argument {option}: {value} is not allowed; allowed: ', done.stderr)


if __name__ == '__main__':
    unittest.main()
