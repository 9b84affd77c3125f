#!/usr/bin/env python3
"""Writes a bag whose odometry is a trajectory, to draw the map that its poses make of the scans.

    bag_with_poses.py my.bag poses.tum out.bag --scan /scan
    map_bag out.bag --matcher odometry_only --set slam/loop_closing=false --out DIR

Takes the scans of one topic that the trajectory has a pose for, by stamps that are the same when rounded to ms, and
from /tf and /tf_static what is not of the odometry frame. Poses are of the base, in a TUM file.
"""

import argparse
import sys

try:
    from geometry_msgs.msg import TransformStamped
    from tf2_msgs.msg import TFMessage

    from scan_bag import rewrite
except ImportError as error:
    sys.exit(f"bag_with_poses.py: {error}: it needs ROS's rosbag and tf2_msgs for this Python, {sys.executable}; "
             "on Debian: apt-get install python3-rosbag python3-tf2-msgs, and /usr/bin first in PATH")
from text_rows import TUM, Mistake, read_rows


def transform_of(pose, stamp, odom, base):
    transform = TransformStamped()
    transform.header.stamp = stamp
    transform.header.frame_id = odom
    transform.child_frame_id = base
    place, turn = transform.transform.translation, transform.transform.rotation
    place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w = pose
    return transform


def without_odometry(message, odom):
    message.transforms = [one for one in message.transforms if one.header.frame_id.lstrip("/") != odom]
    return message


def copy(bag, out, poses, options):
    """The number of scans."""
    scans = 0
    for topic, message, time in bag.read_messages(topics=["/tf", "/tf_static", options.scan]):
        if topic != options.scan:
            if without_odometry(message, options.odom).transforms:
                out.write(topic, message, time)
            continue
        stamp = message.header.stamp
        pose = poses.get(f"{stamp.to_sec():.3f}")
        if pose is not None:
            out.write("/tf", TFMessage([transform_of(pose, stamp, options.odom, options.base)]), time)
            out.write(topic, message, time)
            scans += 1
    return scans


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag")
    parser.add_argument("poses", help="TUM file of the base")
    parser.add_argument("out", help="bag to be written")
    parser.add_argument("--scan", default="/scan", help="topic (default: %(default)s)")
    parser.add_argument("--odom", default="odom_combined", help="odometry frame (default: %(default)s)")
    parser.add_argument("--base", default="base_footprint", help="base frame (default: %(default)s)")
    return parser.parse_args()


def write(options, poses, bag, out):
    if copy(bag, out, poses, options) == 0:
        raise Mistake(f"no scan of {options.scan} has a pose in '{options.poses}': "
                      "stamps have to be the same, rounded to ms")


def main():
    options = parse()
    poses = {f"{row[0]:.3f}": row[1:] for row in read_rows(options.poses, 8, TUM)}
    rewrite(options.bag, options.scan, options.out, lambda bag, out: write(options, poses, bag, out))


if __name__ == "__main__":
    try:
        main()
    except Mistake as mistake:
        print(f"bag_with_poses.py: {mistake}", file=sys.stderr)
        sys.exit(2)
