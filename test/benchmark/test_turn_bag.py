"""benchmark/turn_bag.py: what it does to scans, transforms and truth, and that a mistake is told in one line."""

import math
import os
import unittest

import rosbag
import rospy
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from program_test import ProgramTest

SCANS = 11


def scan(k, increment=0.0):
    return LaserScan(header=rospy.Header(stamp=rospy.Time.from_sec(100.0 + k), frame_id='laser'), angle_min=-1.0, angle_max=0.8,
                     angle_increment=0.2, time_increment=increment, range_max=10.0, ranges=[1.0 + 0.5 * i for i in range(10)])


def link(k):
    """Driven k along x and 2 k to the left, at a yaw of 0.1 k."""
    turn = Quaternion(z=math.sin(0.05 * k), w=math.cos(0.05 * k))
    return TransformStamped(header=rospy.Header(stamp=rospy.Time.from_sec(100.0 + k), frame_id='odom'), child_frame_id='base',
                            transform=Transform(translation=Vector3(x=k, y=2.0 * k), rotation=turn))


class TurnBag(ProgramTest):
    program = 'turn_bag.py'

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for name, increment in (('one.bag', 0.0), ('sweeping.bag', 0.001)):
            with rosbag.Bag(cls.path(name), 'w') as bag:
                for k in range(SCANS):
                    time = rospy.Time.from_sec(100.0 + k)
                    bag.write('/base_scan', scan(k, increment), time)
                    bag.write('/tf', TFMessage([link(k)]), time)
        with open(cls.path('truth.tum'), 'w') as file:
            file.write('# stamp x y z qx qy qz qw\n')
            for k in range(SCANS):
                file.write(f'{100.0 + k} {k} {2 * k} 0 0 0 {math.sin(0.05 * k)} {math.cos(0.05 * k)}\n')

    def turned(self, *arguments):
        done = self.run_on(self.path('one.bag'), self.path('out.bag'), '--truth', self.path('truth.tum'), self.path('out.tum'), *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        with rosbag.Bag(self.path('out.bag')) as bag:
            messages = list(bag.read_messages())
        scans = [message for topic, message, _ in messages if topic == '/base_scan']
        links = {message.transforms[0].header.stamp.to_sec(): message.transforms[0].transform
                 for topic, message, _ in messages if topic == '/tf'}
        with open(self.path('out.tum')) as file:
            truth = {round(float(line.split()[0]), 3): [float(word) for word in line.split()] for line in file}
        self.assertEqual([one.header.stamp for one in scans], sorted(one.header.stamp for one in scans))
        for stamp in [one.header.stamp.to_sec() for one in scans]:  # truth and odometry are still alike
            row, place = truth[round(stamp, 3)], links[stamp]
            for one, other in zip((row[1], row[2], row[6], row[7]),
                                  (place.translation.x, place.translation.y, place.rotation.z, place.rotation.w)):
                self.assertAlmostEqual(one, other, 6)
        return scans, links

    def test_backwards_the_last_scan_is_the_first(self):
        scans, links = self.turned('--backwards')
        self.assertEqual([one.header.stamp.to_sec() for one in scans], [100.0 + k for k in range(SCANS)])
        self.assertAlmostEqual(links[100.0].translation.x, SCANS - 1)
        self.assertAlmostEqual(links[110.0].translation.y, 0.0)
        self.assertEqual(scans[0].ranges, tuple(scan(0).ranges))

    def test_mirrored_left_is_right(self):
        scans, links = self.turned('--mirrored')
        self.assertAlmostEqual(scans[0].angle_min, -0.8, 6)
        self.assertAlmostEqual(scans[0].angle_max, 1.0, 6)
        self.assertEqual(list(scans[0].ranges), list(scan(0).ranges)[::-1])
        self.assertAlmostEqual(links[104.0].translation.y, -8.0)
        self.assertAlmostEqual(links[104.0].rotation.z, -math.sin(0.2))

    def test_a_part_has_its_own_scans_alone(self):
        scans, _ = self.turned('--begin', '0.3', '--end', '0.6')
        self.assertEqual([one.header.stamp.to_sec() for one in scans], [103.0, 104.0, 105.0, 106.0])

    def test_a_sweep_cannot_be_taken_backwards(self):
        done = self.run_on(self.path('sweeping.bag'), self.path('no.bag'), '--backwards')
        self.assertEqual((done.returncode, done.stderr.count('\n')), (2, 1))
        self.assertIn("scans on '/base_scan' have a time_increment of 0.001 s; allowed: 0", done.stderr)

    def test_a_part_without_scans_is_refused(self):
        done = self.run_on(self.path('one.bag'), self.path('no.bag'), '--begin', '0.51', '--end', '0.52')
        self.assertEqual((done.returncode, done.stderr.count('\n')), (2, 1))
        self.assertIn("--begin 0.51 --end 0.52: no scan of '/base_scan' is between", done.stderr)
        self.assertFalse(os.path.exists(self.path('no.bag')))


if __name__ == '__main__':
    unittest.main()
