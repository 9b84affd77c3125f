"""What the launch files make of arguments as people write them."""

import os
import pathlib
import unittest

import roslaunch.config
import roslaunch.xmlloader

PACKAGE = pathlib.Path(__file__).resolve().parents[2]


def remaps_of_rviz(*arguments):
    os.environ['ROS_PACKAGE_PATH'] = f"{PACKAGE}:{os.environ.get('ROS_PACKAGE_PATH', '')}"
    config = roslaunch.config.ROSLaunchConfig()
    roslaunch.xmlloader.XmlLoader().load(str(PACKAGE / 'launch/slam.launch'), config, verbose=False,
                                         argv=['rviz:=true', *arguments])
    (rviz,) = [node for node in config.nodes if node.type == 'rviz']
    return dict(rviz.remap_args)


class LaunchFiles(unittest.TestCase):

    def test_rviz_shows_the_scans_of_several_lasers_however_their_topics_are_quoted(self):
        for topics in ['[front, rear, /side/scan]', '["front","rear","/side/scan"]',
                       "['front', 'rear', '/side/scan']", '[ "front" , rear, /side/scan ]']:
            with self.subTest(topics=topics):
                self.assertEqual(remaps_of_rviz('scan_topics:=' + topics),
                                 {'/scan': 'front', '/scan_2': 'rear', '/scan_3': '/side/scan'})
        self.assertEqual(remaps_of_rviz('scan_topic:=/base_scan'), {'/scan': '/base_scan'})

    def test_localise_is_slam_in_a_map_that_stays_as_it_is(self):
        os.environ['ROS_PACKAGE_PATH'] = f"{PACKAGE}:{os.environ.get('ROS_PACKAGE_PATH', '')}"
        config = roslaunch.config.ROSLaunchConfig()
        roslaunch.xmlloader.XmlLoader().load(
            str(PACKAGE / 'launch/localise.launch'), config, verbose=False,
            argv=['map:=/maps/office.slam', 'initial_pose_x:=1.5', 'tf_while_lost:=stop'])
        (slam,) = config.nodes
        self.assertEqual(dict(slam.remap_args), {'pose': 'amcl_pose', 'scan': 'scan'})
        values = {name: param.value for name, param in config.params.items()}
        self.assertEqual(values['/slam/initial_map'], '/maps/office.slam')
        self.assertIs(values['/slam/slam/update_map'], False)
        self.assertEqual(values['/slam/start_x'], 1.5)
        self.assertEqual(values['/slam/tf_while_lost'], 'stop')
        self.assertNotIn('/slam/start_y', values)


if __name__ == '__main__':
    unittest.main()
