"""A slam_node under load: a recording played to it, and what comes back measured."""

import collections
import os
import random
import signal
import struct
import subprocess
import sys
import time

import genpy
import rosbag
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from matchbox_slam.msg import MatchInfo
from report import SOURCE, program, run

# `passed`: seconds from the start of a lap to the stamp; `due`: until it is sent.
Event = collections.namedtuple('Event', 'due passed message')


def due(event):
    return event.due


class RawScan(LaserScan):
    """A scan that stays as it was read: packing a thousand ranges anew would be the bottleneck."""

    def __init__(self, packed):
        super().__init__()
        self.packed = bytearray(packed)

    def set_stamp(self, stamp):
        # A header starts with its sequence number; the stamp follows.
        struct.pack_into('<II', self.packed, 4, stamp.secs, stamp.nsecs)

    def serialize(self, buff):
        buff.write(self.packed)


class StampedTransforms:
    def __init__(self, message):
        self.message = message

    def set_stamp(self, stamp):
        for transform in self.message.transforms:
            transform.header.stamp = stamp


class Recording:
    """The scans and transforms of a simulated bag, driven forth and back without end: the way back
    is the way there in reverse, so that neither odometry nor time ever jumps."""

    def __init__(self, bag, late_transforms=0.0):
        messages = []
        with rosbag.Bag(bag) as recorded:
            for topic, raw, _ in recorded.read_messages(topics=['/base_scan', '/tf'], raw=True):
                messages.append(unpack(topic, raw[1], late_transforms))
        first = min(passed for passed, _, _ in messages)
        length = max(passed for passed, _, _ in messages) - first
        # A lap starts after the last stamp of the one before.
        self.lap = length + 0.01
        self.forth = sorted((Event(passed - first + late, passed - first, message)
                             for passed, late, message in messages), key=due)
        self.back = sorted((Event(length - event.passed + event.due - event.passed,
                                  length - event.passed, event.message) for event in self.forth),
                           key=due)

    def drive(self, start):
        """When to send what, with stamps from `start` on; a message is good until the next."""
        laps = 0
        while True:
            begin = start + laps * self.lap
            for event in self.back if laps % 2 else self.forth:
                stamp = genpy.Time.from_sec(begin + event.passed)
                event.message.set_stamp(stamp)
                yield begin + event.due, stamp, event.message
            laps += 1


def unpack(topic, packed, late_transforms):
    """The stamp of a message, how much later it is sent, and the message."""
    if topic == '/base_scan':
        _, seconds, nanoseconds = struct.unpack_from('<III', packed)
        return seconds + 1e-9 * nanoseconds, 0.0, RawScan(packed)
    transforms = TFMessage().deserialize(packed)
    return (transforms.transforms[0].header.stamp.to_sec(), late_transforms,
            StampedTransforms(transforms))


class Measured:
    """What came back for each scan, by its stamp."""

    def __init__(self):
        self.sent = {}         # stamp -> seconds
        self.to_pose = []      # [s] from a scan to its pose
        self.match_times = []  # [s]
        self.pose_sent = []    # when the scans of these were sent
        self.changed = []      # when the map transform was another one than before
        self.transform = None  # the newest
        self.unproven = 0
        self.skipped = {}      # reason -> scans

    def on_pose(self, message):
        stamp = message.header.stamp.to_nsec()
        if stamp in self.sent:
            self.to_pose.append(time.perf_counter() - self.sent[stamp])
            self.pose_sent.append(self.sent.pop(stamp))

    def on_transforms(self, message):
        now = time.perf_counter()
        for transform in message.transforms:
            if transform.header.frame_id == 'map':
                moved, turned = transform.transform.translation, transform.transform.rotation
                numbers = (moved.x, moved.y, turned.z, turned.w)
                if numbers != self.transform:
                    self.changed.append(now)
                    self.transform = numbers

    def to_transform(self):
        """[s] from each scan to its map transform: the first new one that is no earlier scan's.
        The timer repeats them in between."""
        times = []
        changed = collections.deque(self.changed)
        for sent in sorted(self.pose_sent):
            while changed and changed[0] < sent:
                changed.popleft()
            if changed:
                times.append(changed.popleft() - sent)
        return times

    def on_match(self, message):
        self.match_times.append(message.match_time)
        self.unproven += not message.proven

    def on_diagnostics(self, message):
        for status in message.status:
            for value in status.values:
                if value.key.startswith('Scans skipped: '):
                    self.skipped[value.key[len('Scans skipped: '):]] = int(value.value)


class Session:
    """A ROS master and a slam_node of its own; `with` ends both."""

    def __init__(self, matcher, settings=(), sim_time=False):
        self.matcher = matcher
        self.settings = ['max_lag=1.0', 'scan_topics=[]'] + list(settings)
        self.sim_time = sim_time
        self.measured = Measured()
        self.processes = []

    def start(self, *command):
        self.processes.append(subprocess.Popen(command, stdout=subprocess.DEVNULL, env=os.environ))
        return self.processes[-1]

    def __enter__(self):
        try:
            self.open()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_):
        self.close()

    def open(self):
        os.environ['ROS_MASTER_URI'] = 'http://127.0.0.1:%d' % random.randint(20000, 30000)
        self.start('roscore', '-p', os.environ['ROS_MASTER_URI'].rsplit(':', 1)[1])
        while subprocess.run(['rosparam', 'list'], stdout=subprocess.DEVNULL,
                             stderr=subprocess.DEVNULL, check=False).returncode != 0:
            if self.processes[0].poll() is not None:
                sys.exit('roscore ended with %d' % self.processes[0].returncode)
            time.sleep(0.2)
        run(['rosparam', 'set', 'use_sim_time', str(self.sim_time).lower()])
        run(['rosparam', 'load', os.path.join(SOURCE, 'config', self.matcher + '.yaml'), 'slam'])
        frames = ['matcher=' + self.matcher, 'base_frame=base_footprint', 'odom_frame=odom_combined']
        for setting in frames + self.settings:
            run(['rosparam', 'set', 'slam/' + setting.split('=')[0], setting.split('=', 1)[1]])
        prefix = run(['catkin_find', '--first-only', 'matchbox_slam', 'slam_node']).strip()
        self.node = self.start(prefix, '__name:=slam', 'scan:=base_scan')
        self.connect()

    def connect(self):
        rospy.init_node('load', disable_signals=True)
        measured = self.measured
        self.scans = rospy.Publisher('base_scan', LaserScan, queue_size=1000, tcp_nodelay=True)
        self.transforms = rospy.Publisher('tf', TFMessage, queue_size=1000, tcp_nodelay=True)
        self.clock = rospy.Publisher('clock', Clock, queue_size=1000)
        for name, kind, callback in [('pose', PoseWithCovarianceStamped, measured.on_pose),
                                     ('tf', TFMessage, measured.on_transforms),
                                     ('match_info', MatchInfo, measured.on_match),
                                     ('diagnostics', DiagnosticArray, measured.on_diagnostics)]:
            rospy.Subscriber(name, kind, callback, queue_size=1000, tcp_nodelay=True)
        while self.scans.get_num_connections() == 0 or self.transforms.get_num_connections() < 2:
            if self.node.poll() is not None:
                sys.exit('slam_node ended with %d' % self.node.returncode)
            time.sleep(0.1)

    def close(self):
        rospy.signal_shutdown('done')
        for process in reversed(self.processes):
            process.send_signal(signal.SIGCONT)
            process.send_signal(signal.SIGINT)
            process.wait()

    def publish(self, stamp, message):
        if isinstance(message, RawScan):
            self.measured.sent[stamp.to_nsec()] = time.perf_counter()
            self.scans.publish(message)
            return
        self.transforms.publish(message.message)

    def cpu_seconds(self):
        with open('/proc/%d/stat' % self.node.pid) as file:
            fields = file.read().rsplit(')', 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')

    def memory_mb(self):
        with open('/proc/%d/status' % self.node.pid) as file:
            return next(int(line.split()[1]) for line in file if line.startswith('VmRSS')) / 1024


def simulated(folder, rate, *options, odometry_rate=100, late_transforms=0.0):
    """A bag of the rooms with so many scans and transforms a second."""
    bag = os.path.join(folder, 'rooms-%d.bag' % rate)
    run(program('simulate') + ['--world', 'rooms', '--seed', '1', '--bag', bag, '--truth',
                               bag + '.tum', '--scan-rate', str(rate), '--odometry-rate',
                               str(odometry_rate)] + list(options))
    return Recording(bag, late_transforms)
