#!/usr/bin/env python3
"""Takes pictures of rviz with its panel in each state, of simulated drives, on a screen of its own.

Build and source the workspace, build the program that looks (`ninja -C .workspace/build panel_pictures`),
have Xvfb installed (package xvfb), then:

    benchmark/panel_pictures.py --out DIR [--only NAME]...

Fails when a state never comes, or when a display of rviz has a warning or an error in a picture. OpenGL is
software, so that it takes no graphics card.
"""

import argparse
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time

import rosbag

from report import SOURCE, program, run

# Name: options of `simulate`, speed of the replay, and what to take a picture of, in this order: name, part
# of the panel, and what it says then.
SCENES = {
    'tracking': (['--world', 'rooms', '--seed', '1', '--duration', '60', '--second-laser', '-0.3,0,3.14159'], 2,
                 [('tracking', 'key_scans', '30')]),
    'loop': (['--world', 'loop', '--seed', '3', '--beams', '200', '--scan-rate', '5', '--speed', '1'], 6,
             [('loop', 'advice', 'A loop was closed')]),
    'lost': (['--world', 'rooms', '--seed', '1', '--duration', '110', '--fault', 'kidnap:85::5'], 2,
             [('lost', 'state', 'Lost'), ('places', 'places', '')]),
}


class Xvfb:
    """A screen without a graphics card."""

    def __enter__(self):
        reading, writing = os.pipe()
        self.process = subprocess.Popen(
            ['Xvfb', '-displayfd', str(writing), '-screen', '0', '1400x900x24', '-nolisten', 'tcp'],
            pass_fds=[writing], stderr=subprocess.DEVNULL)
        os.close(writing)
        with os.fdopen(reading) as display:
            return ':' + display.readline().strip()

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()


def free_port():
    with socket.socket() as probe:
        probe.bind(('', 0))
        return probe.getsockname()[1]


def end(process):
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=30)


def scan_topics(bag):
    with rosbag.Bag(bag) as recorded:
        return sorted(topic for topic, info in recorded.get_type_and_topic_info().topics.items()
                      if info.msg_type == 'sensor_msgs/LaserScan')


def play(bag, rate, environment):
    return subprocess.Popen(
        ['rosbag', 'play', '--quiet', '--clock', '--queue=100000', '--delay=1', '--wait-for-subscribers', '--rate',
         str(rate), bag, '--topics', '/tf', '/tf_static', *scan_topics(bag)], env=environment)


def photograph(name, folder, out, environment):
    simulation, rate, pictures = SCENES[name]
    bag = os.path.join(folder, name + '.bag')
    run(program('simulate') + simulation + ['--bag', bag, '--truth', bag + '.tum'])
    lasers = scan_topics(bag)
    launch = os.path.join(folder, name + '.launch')
    with open(launch, 'w') as file:
        file.write('''<launch>
          <param name="/use_sim_time" value="true"/>
          <include file="$(find matchbox_slam)/launch/slam.launch">
            <arg name="scan_topics" value="[%s]"/>
            <arg name="base_frame" value="base_footprint"/>
            <arg name="odom_frame" value="odom_combined"/>
            <arg name="max_lag" value="0"/>
          </include>
        </launch>''' % ', '.join(lasers))
    port = free_port()
    environment = dict(environment, ROS_MASTER_URI='http://localhost:%d' % port)
    node = subprocess.Popen(['roslaunch', '-p', str(port), launch], env=environment)
    looking = program('panel_pictures') + [
        os.path.join(SOURCE, 'rviz', 'slam.rviz'), '100']
    for picture, part, words in pictures:
        looking += [os.path.join(out, picture + '.png'), part, words]
    player = None
    try:
        while subprocess.run(['rosnode', 'ping', '-c', '1', '/slam'], env=environment,
                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode != 0:
            time.sleep(0.5)
        rviz = subprocess.Popen(looking + ['%s:=%s' % names for names in zip(['/scan', '/scan_2'], lasers)], env=environment)
        time.sleep(3)  # until the window is there
        player = play(bag, rate, environment)
        return rviz.wait()
    finally:
        if player:
            end(player)
        end(node)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--out', required=True, help='folder for the pictures')
    parser.add_argument('--only', action='append', choices=SCENES, help='may be given again')
    arguments = parser.parse_args()
    out = os.path.abspath(arguments.out)
    os.makedirs(out, exist_ok=True)
    failed = []
    with tempfile.TemporaryDirectory() as folder, Xvfb() as display:
        environment = dict(os.environ, DISPLAY=display, LIBGL_ALWAYS_SOFTWARE='1', ROS_HOME=folder,
                           HOME=folder)
        for name in arguments.only or SCENES:
            if photograph(name, folder, out, environment) != 0:
                failed.append(name)
    if failed:
        sys.exit('failed: ' + ', '.join(failed))


if __name__ == '__main__':
    main()
