#!/usr/bin/env python3
"""Ends a slam_node that has a backlog at random moments, and looks at what it leaves behind: SIGINT, SIGTERM and
roslaunch's own shutdown in turn, while maps are saved all the time. Writes SIGNALS.md.

Build and source the workspace, then:

    benchmark/run_signals.py [--out DIR] [--moments 50] [--seed 1] [--longest 2.0]

Every file has to be whole, every scan counted, and the end to come within 2 s. Exits 1 otherwise.
"""

import argparse
import collections
import gzip
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time

import rosbag
import rospy
import yaml
from std_srvs.srv import Trigger

from report import default_folder, heading, run, simulate

WAYS = ('SIGINT', 'SIGTERM', 'roslaunch')
RATE = 30  # the recording of 60 s is played within 2
LATEST = 5.0  # [s] after the start of playing
FILES = {'node.tum', 'events.yaml', 'map.pgm', 'map.yaml', 'map.png', 'map.slam'}
# Some 300 ms a match.
SETTINGS = {'base_frame': 'base_footprint', 'odom_frame': 'odom_combined', 'queue_size': 10000,
            'matcher': 'monte_carlo', 'monte_carlo/max_tries': 200000,
            'monte_carlo/max_failed_tries': 200000}

Ending = collections.namedtuple('Ending', 'way moment took received used faults')


def launch_file(folder, settings):
    """Of a launch file with the node in it."""
    path = os.path.join(folder, 'node.launch')
    parameters = ''.join('<param name="%s" value="%s"/>' % item for item in settings.items())
    with open(path, 'w') as file:
        file.write('<launch><node pkg="matchbox_slam" type="slam_node" name="slam" output="screen">'
                   '<remap from="scan" to="base_scan"/>%s</node></launch>' % parameters)
    return path


def command_of(way, folder, settings):
    if way == 'roslaunch':
        return ['roslaunch', '--wait', launch_file(folder, settings)]
    node = run(['catkin_find', '--first-only', 'matchbox_slam', 'slam_node']).strip()
    return [node, '__name:=slam', 'scan:=base_scan'] + [
        '_%s:=%s' % item for item in settings.items()]


def save_maps(stop):
    """Has the map saved again and again."""
    save = rospy.ServiceProxy('/slam/save_map', Trigger)
    while not stop.is_set():
        try:
            save()
        except (rospy.ServiceException, rospy.ROSException):
            time.sleep(0.02)  # it is ending


def fault_of_file(path):
    """What is wrong with a file; empty: it is whole."""
    with open(path, 'rb') as file:
        content = file.read()
    name = os.path.basename(path)
    try:
        if name.endswith('.slam'):
            return '' if gzip.decompress(content).startswith(b'matchbox_slam map') else 'no map'
        if name.endswith('.png'):
            return '' if content.endswith(b'IEND\xaeB`\x82') else 'cut off'
        if name.endswith('.pgm'):
            header = re.match(rb'P5\s(?:#.*\n)*(\d+) (\d+)\s255\n', content)
            pixels = int(header.group(1)) * int(header.group(2))
            return '' if len(content) == header.end() + pixels else 'cut off'
        if name.endswith('.yaml'):
            yaml.safe_load(content)
            return '' if content.endswith(b'\n') else 'cut off'
        return '' if all(len(line.split()) == 8 for line in content.splitlines()) else 'cut off'
    except (AttributeError, EOFError, OSError, ValueError, yaml.YAMLError) as error:
        return str(error)


def faults_of_files(folder):
    names = set(os.listdir(folder))
    faults = ['%s is left' % name for name in sorted(names - FILES)]
    for name in sorted(names & FILES):
        fault = fault_of_file(os.path.join(folder, name))
        faults += ['%s: %s' % (name, fault)] if fault else []
    return faults


def faults_of_account(log, folder, scans_sent):
    """With how many scans it said it received and used."""
    account = re.search(r'mapping has ended: (\d+) scans received, (\d+) used, (\d+) skipped', log)
    if not account:
        return 0, 0, ['it does not tell what became of the scans']
    received, used, skipped = map(int, account.groups())
    trajectory = os.path.join(folder, 'node.tum')
    poses = 0
    if os.path.exists(trajectory):
        with open(trajectory) as file:
            poses = sum(1 for _ in file)
    faults = []
    if received != used + skipped:
        faults.append('%d received are not %d used and %d skipped' % (received, used, skipped))
    if poses != used:
        faults.append('%d used, and %d poses' % (used, poses))
    if scans_sent is not None and received != scans_sent:
        faults.append('%d sent, and %d received' % (scans_sent, received))
    return received, used, faults


def end_at(way, moment, bag, scans, folder):
    """One run, ended so long [s] after the recording began to play."""
    results = os.path.join(folder, 'results')
    os.mkdir(results)
    settings = dict(SETTINGS, map_file=os.path.join(results, 'map'),
                    trajectory_file=os.path.join(results, 'node.tum'),
                    events_file=os.path.join(results, 'events.yaml'))
    log = os.path.join(folder, 'log')
    with open(log, 'w') as output:
        process = subprocess.Popen(command_of(way, folder, settings), stdout=output,
                                   stderr=subprocess.STDOUT)
    rospy.wait_for_service('/slam/save_map', 30.0)
    stop = threading.Event()
    saver = threading.Thread(target=save_maps, args=(stop,))
    # Else it plays 0.2 s after it begins, whether the node has connected or not.
    player = subprocess.Popen(['rosbag', 'play', '--quiet', '--wait-for-subscribers', '--queue=10000', '-r',
                               str(RATE), bag, '--topics', '/base_scan', '/tf'],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    saver.start()
    end = time.monotonic() + moment
    played = None
    while time.monotonic() < end:
        played = played or (player.poll() is not None and time.monotonic())
        time.sleep(min(0.01, max(0.0, end - time.monotonic())))
    was_played = played and time.monotonic() > played + 1.0
    begin = time.monotonic()
    process.send_signal(signal.SIGTERM if way == 'SIGTERM' else signal.SIGINT)
    try:
        code = process.wait(30)
    except subprocess.TimeoutExpired:
        process.kill()
        code = process.wait()
    took = time.monotonic() - begin
    stop.set()
    player.terminate()
    player.wait()
    saver.join()
    with open(log) as file:
        received, used, faults = faults_of_account(file.read(), results,
                                                   scans if was_played else None)
    faults += ['exit code %d' % code] if code else []
    return Ending(way, moment, took, received, used, faults + faults_of_files(results))


def report(endings, longest, arguments):
    lines = heading('Ended at random moments', 'run_signals.py', arguments) + [
        '', '`slam_node` with a backlog (`monte_carlo` with 300 ms a match; 1,201 scans played within 2 s) '
        'is ended at random moments of', 'the first %g s, while `~save_map` is called again and again. '
        'Afterwards files are read, and the account of the scans is' % LATEST,
        'compared with the trajectory.', '',
        '| ended by | runs | median | longest | scans received | used | faults |', '|---|---|---|---|---|---|---|']
    for way in WAYS:
        those = [ending for ending in endings if ending.way == way]
        times = sorted(ending.took for ending in those) or [float('nan')]
        lines.append('| %s | %d | %.2f s | %.2f s | %d to %d | %d to %d | %d |' % (
            way, len(those), times[len(times) // 2], times[-1],
            min(ending.received for ending in those), max(ending.received for ending in those),
            min(ending.used for ending in those), max(ending.used for ending in those),
            sum(1 for ending in those if faults_in(ending, longest))))
    for ending in endings:
        lines += ['', '- %s after %.3f s: %s' % (ending.way, ending.moment, fault)
                  ] if (fault := '; '.join(faults_in(ending, longest))) else []
    return '\n'.join(lines) + '\n'


def faults_in(ending, longest):
    late = ['it took %.2f s' % ending.took] if ending.took > longest else []
    return late + ending.faults


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n', maxsplit=1)[0])
    parser.add_argument('--out', default=default_folder())
    parser.add_argument('--moments', type=int, default=50)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--longest', type=float, default=2.0, help='[s] that an end may take')
    arguments = parser.parse_args()
    chance = random.Random(arguments.seed)
    os.environ['ROS_MASTER_URI'] = 'http://127.0.0.1:%d' % random.randint(20000, 30000)
    master = subprocess.Popen(['roscore', '-p', os.environ['ROS_MASTER_URI'].rsplit(':', 1)[1]],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    endings = []
    try:
        with tempfile.TemporaryDirectory() as folder:
            os.environ['ROS_LOG_DIR'] = os.path.join(folder, 'log')
            bag, _ = simulate('rooms', 1, folder, '--duration', '60')
            with rosbag.Bag(bag) as recorded:
                scans = recorded.get_message_count('/base_scan')
            rospy.init_node('signals', disable_signals=True)
            for i in range(arguments.moments):
                run_folder = os.path.join(folder, str(i))
                os.mkdir(run_folder)
                endings.append(end_at(WAYS[i % len(WAYS)], chance.uniform(0.0, LATEST), bag, scans,
                                      run_folder))
                print(endings[-1], flush=True)
    finally:
        master.send_signal(signal.SIGINT)
        master.wait()
    os.makedirs(arguments.out, exist_ok=True)
    with open(os.path.join(arguments.out, 'SIGNALS.md'), 'w') as file:
        file.write(report(endings, arguments.longest, sys.argv[1:]))
    if any(faults_in(ending, arguments.longest) for ending in endings):
        sys.exit('run_signals.py: there are faults, see %s/SIGNALS.md' % arguments.out)


if __name__ == '__main__':
    main()
