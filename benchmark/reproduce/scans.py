"""Scans of a bag as points in the frame of the base."""

import numpy
import rosbag
import rospy
import tf2_py
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3


class NoScan(Exception):
    """The bag has no scan of that stamp."""


def bare(frame):
    """Frames from before tf2 begin with a slash."""
    return frame.lstrip('/')


def read_messages(bags, topics, stamps, stamp_offset):
    """The scans of the given stamps, in their order. The offset is what was added to the scans' stamps."""
    found = {}
    for path in bags:
        with rosbag.Bag(path) as bag:
            for _, message, _ in bag.read_messages(topics=topics):
                stamp = message.header.stamp.to_sec() + stamp_offset
                for wanted in stamps:
                    if abs(stamp - wanted) < 1e-3:
                        found.setdefault(wanted, message)
                if len(found) == len(stamps):
                    return [found[wanted] for wanted in stamps]
    raise NoScan('no scan on %s at %s' % (', '.join(topics), sorted(set(stamps) - set(found))))


def laser_mount(bags, base, laser):
    """Rotation matrix and translation of the laser on the base, from the first transforms that tell."""
    if bare(base) == bare(laser):
        return numpy.eye(3), numpy.zeros(3)
    buffer = tf2_py.BufferCore(rospy.Duration(1e9))
    for path in bags:
        with rosbag.Bag(path) as bag:
            for topic, message, _ in bag.read_messages(topics=['/tf', '/tf_static', 'tf', 'tf_static']):
                for transform in message.transforms:
                    buffer.set_transform(as_installed(transform), 'bag')
                    if buffer.can_transform_core(bare(base), bare(laser), rospy.Time(0))[0]:
                        return split(buffer.lookup_transform_core(bare(base), bare(laser),
                                                                  rospy.Time(0)).transform)
    raise NoScan('no transform from %s to %s' % (base, laser))


def as_installed(recorded):
    """A transform of the bag's own message types as one of those that tf2 knows."""
    q, t = recorded.transform.rotation, recorded.transform.translation
    transform = TransformStamped()
    transform.header.stamp = recorded.header.stamp
    transform.header.frame_id = bare(recorded.header.frame_id)
    transform.child_frame_id = bare(recorded.child_frame_id)
    transform.transform.translation = Vector3(t.x, t.y, t.z)
    transform.transform.rotation = Quaternion(q.x, q.y, q.z, q.w)
    return transform


def split(transform):
    q, t = transform.rotation, transform.translation
    rotation = numpy.array([
        [1 - 2 * (q.y ** 2 + q.z ** 2), 2 * (q.x * q.y - q.z * q.w), 2 * (q.x * q.z + q.y * q.w)],
        [2 * (q.x * q.y + q.z * q.w), 1 - 2 * (q.x ** 2 + q.z ** 2), 2 * (q.y * q.z - q.x * q.w)],
        [2 * (q.x * q.z - q.y * q.w), 2 * (q.y * q.z + q.x * q.w), 1 - 2 * (q.x ** 2 + q.y ** 2)]])
    return rotation, numpy.array([t.x, t.y, t.z])


def points(message, mount):
    """Hits in the plane of the base, n x 2."""
    ranges = numpy.asarray(message.ranges, float)
    angles = message.angle_min + message.angle_increment * numpy.arange(len(ranges))
    hits = numpy.isfinite(ranges) & (ranges > message.range_min) & (ranges < message.range_max)
    in_laser = numpy.stack([ranges * numpy.cos(angles), ranges * numpy.sin(angles),
                            numpy.zeros(len(ranges))], axis=1)[hits]
    rotation, translation = mount
    return (in_laser @ rotation.T + translation)[:, :2]
