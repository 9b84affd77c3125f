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


if __name__ == '__main__':
    unittest.main()
