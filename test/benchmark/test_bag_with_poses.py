"""benchmark/bag_with_poses.py: scans with the poses of a trajectory as their odometry."""

import os
import subprocess
import sys
import tempfile
import unittest

import rosbag
import rospy
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
PROGRAM = os.path.join(SOURCE, 'benchmark', 'bag_with_poses.py')


def link(parent, child, x):
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id = parent
    transform.transform.translation.x = x
    return transform


class BagWithPoses(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        with rosbag.Bag(cls.path('run.bag'), 'w') as bag:
            for k in range(3):
                time = rospy.Time.from_sec(100.0 + k)
                bag.write('/tf', TFMessage([link('odom_combined', 'base_footprint', 9.0),
                                            link('base_footprint', 'laser', 0.1)]), time)
                bag.write('/scan', LaserScan(header=rospy.Header(stamp=time)), time)
        with open(cls.path('poses.tum'), 'w') as file:
            file.write('# poses\n100 0 0 0 0 0 0 1\n102.0004 2 1 0 0 0 0.6 0.8\n')

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder.name, name)

    def run_program(self, bag='run.bag', poses='poses.tum', *arguments):
        return subprocess.run([sys.executable, PROGRAM, self.path(bag), self.path(poses), self.path('out.bag'),
                               *arguments], capture_output=True, text=True, timeout=60)

    def test_scans_with_a_pose_get_it_for_odometry(self):
        done = self.run_program()
        self.assertEqual(done.returncode, 0, done.stderr)
        poses, mounts, scans = [], 0, []
        with rosbag.Bag(self.path('out.bag')) as bag:
            for topic, message, _ in bag.read_messages():
                if topic == '/scan':
                    scans.append(message.header.stamp.to_sec())
                    continue
                for one in message.transforms:
                    if one.child_frame_id == 'laser':
                        mounts += 1
                    else:
                        place = one.transform
                        poses.append((place.translation.x, place.translation.y, place.rotation.z, place.rotation.w))
        self.assertEqual(scans, [100.0, 102.0])
        self.assertEqual(poses, [(0.0, 0.0, 0.0, 1.0), (2.0, 1.0, 0.6, 0.8)])
        self.assertEqual(mounts, 3)

    def test_a_mistake_is_told_in_one_line(self):
        for done, text in ((self.run_program('missing.bag'), 'missing.bag'), (self.run_program(poses='run.bag'), 'TUM'),
                           (self.run_program('run.bag', 'poses.tum', '--scan', '/none'), 'no scan of /none')):
            self.assertEqual(done.returncode, 2)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertIn(text, done.stderr)


if __name__ == '__main__':
    unittest.main()
