"""benchmark/bag_with_poses.py: scans with the poses of a trajectory as their odometry."""

import os
import shutil
import unittest

import rosbag
import rospy
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from program_test import ProgramTest


def link(parent, child, x):
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id = parent
    transform.transform.translation.x = x
    return transform


class BagWithPoses(ProgramTest):
    program = 'bag_with_poses.py'

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        with rosbag.Bag(cls.path('run.bag'), 'w') as bag:
            for k in range(3):
                time = rospy.Time.from_sec(100.0 + k)
                bag.write('/tf', TFMessage([link('odom_combined', 'base_footprint', 9.0),
                                            link('base_footprint', 'laser', 0.1)]), time)
                bag.write('/scan', LaserScan(header=rospy.Header(stamp=time)), time)
        with open(cls.path('poses.tum'), 'w') as file:
            file.write('# poses\n100 0 0 0 0 0 0 1\n102.0004 2 1 0 0 0 0.6 0.8\n')
        with open(cls.path('others.tum'), 'w') as file:
            file.write('200 0 0 0 0 0 0 1\n')
        with open(cls.path('run.bag'), 'rb') as file, open(cls.path('damaged.bag'), 'wb') as damaged:
            whole = file.read()
            middle = whole.index(b'laser') - 40
            damaged.write(whole[:middle] + b'\xff' * 30 + whole[middle + 30:])

    def run_program(self, bag='run.bag', poses='poses.tum', *arguments, out='out.bag'):
        return self.run_on(self.path(bag), self.path(poses), self.path(out), *arguments)

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
        os.remove(self.path('out.bag'))

    def test_a_mistake_is_told_in_one_line(self):
        for done, text in ((self.run_program('missing.bag'), 'missing.bag'), (self.run_program(poses='run.bag'), 'TUM'),
                           (self.run_program('run.bag', 'poses.tum', '--scan', '/tf'), "there: /scan"),
                           (self.run_program(poses='others.tum'), 'no scan of /scan has a pose'),
                           (self.run_program('damaged.bag'), 'damaged.bag'),
                           (self.run_program(out='missing/out.bag'), 'missing/out.bag')):
            self.assertEqual(done.returncode, 2)
            told = [line for line in done.stderr.splitlines() if line.startswith('bag_with_poses.py: ')]
            self.assertEqual(len(told), 1, done.stderr)
            self.assertNotIn('Traceback', done.stderr)
            self.assertIn(text, told[0])
        self.assertEqual([name for name in os.listdir(self.folder.name) if 'out' in name], [])

    def test_a_bag_may_take_the_place_of_the_one_that_it_is_of(self):
        shutil.copy(self.path('run.bag'), self.path('same.bag'))
        self.assertEqual(self.run_program('same.bag', out='same.bag').returncode, 0)
        with rosbag.Bag(self.path('same.bag')) as bag:
            self.assertEqual(bag.get_message_count('/scan'), 2)


if __name__ == '__main__':
    unittest.main()
