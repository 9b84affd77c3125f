"""benchmark/thin_bag.py: which scans and beams are left, and that a mistake ends it with one line that says what to do."""

import os
import unittest

import rosbag
import rospy
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from program_test import ProgramTest

SCANS = 9
BEAMS = 10


def scan(k):
    ranges = [1.0 + 0.1 * i for i in range(BEAMS)]
    return LaserScan(header=rospy.Header(stamp=rospy.Time.from_sec(100.0 + k), frame_id='laser'), angle_min=-1.0, angle_max=0.8,
                     angle_increment=0.2, time_increment=0.001, scan_time=0.1, range_max=10.0, ranges=ranges, intensities=ranges)


class ThinBag(ProgramTest):
    program = 'thin_bag.py'

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        with rosbag.Bag(cls.path('one.bag'), 'w') as bag, rosbag.Bag(cls.path('two.bag'), 'w') as two:
            for k in range(SCANS):
                for out in (bag, two):
                    out.write('/base_scan', scan(k))
                    out.write('/tf', TFMessage([TransformStamped()]))
                two.write('/other_scan', scan(k))

    def thinned(self, *arguments):
        done = self.run_on(self.path('one.bag'), self.path('thin.bag'), *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        with rosbag.Bag(self.path('thin.bag')) as bag:
            messages = list(bag.read_messages())
        self.assertEqual(sum(topic == '/tf' for topic, _, _ in messages), SCANS)
        scans = [message for topic, message, _ in messages if topic == '/base_scan']
        self.assertIn(f': {len(scans)} scans', done.stdout)
        return scans

    def test_every_second_scan_is_left_as_it_was(self):
        scans = self.thinned('--scans', '2')
        self.assertEqual([one.header.stamp.to_sec() for one in scans], [100.0, 102.0, 104.0, 106.0, 108.0])
        self.assertEqual((len(scans[0].ranges), len(scans[0].intensities)), (BEAMS, BEAMS))
        self.assertAlmostEqual(scans[0].time_increment, 0.001, 6)
        self.assertAlmostEqual(scans[0].angle_max, 0.8, 6)

    def test_every_fourth_beam_keeps_its_angle_and_time(self):
        scans = self.thinned('--beams', '4', '--scan', '/base_scan')
        self.assertEqual(len(scans), SCANS)
        self.assertEqual([round(value, 3) for value in scans[3].ranges], [1.0, 1.4, 1.8])
        self.assertEqual([round(value, 3) for value in scans[3].intensities], [1.0, 1.4, 1.8])
        self.assertAlmostEqual(scans[3].angle_increment, 0.8, 6)
        self.assertAlmostEqual(scans[3].angle_max, -1.0 + 2 * 0.8, 6)
        self.assertAlmostEqual(scans[3].time_increment, 0.004, 6)

    def test_only_the_scans_of_one_topic_are_left(self):
        done = self.run_on(self.path('two.bag'), self.path('first.bag'), '--scan', '/other_scan', '--scans', '3')
        self.assertEqual(done.returncode, 0, done.stderr)
        with rosbag.Bag(self.path('first.bag')) as bag:
            self.assertEqual(set(bag.get_type_and_topic_info().topics), {'/tf', '/other_scan'})

    def test_a_mistake_is_told_in_one_line_and_leaves_nothing(self):
        with open(self.path('one.bag'), 'rb') as file:
            whole = file.read()
        middle = whole.index(b'laser', len(whole) // 2)
        with open(self.path('damaged.bag'), 'wb') as file:
            file.write(whole[:middle + 5] + 100 * b'\xff' + whole[middle + 105:])
        for arguments, words in (((self.path('damaged.bag'),), 'cannot be copied to'),
                                 ((self.path('two.bag'),), 'there: /base_scan, /other_scan'),
                                 ((self.path('one.bag'), '--scan', '/scan'), "'/scan' is no topic"),
                                 ((self.path('no.bag'),), 'No such file')):
            done = self.run_on(arguments[0], self.path('out.bag'), *arguments[1:])
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(words, done.stderr)
            self.assertEqual(done.stderr.count('\n'), 1, done.stderr)
        done = self.run_on(self.path('one.bag'), self.path('out.bag'), '--beams', '0')
        self.assertEqual(done.returncode, 2)
        self.assertIn('0 is not allowed; allowed: at least 1', done.stderr)
        self.assertFalse([name for name in os.listdir(self.folder.name) if name.startswith('out.bag')])


if __name__ == '__main__':
    unittest.main()
