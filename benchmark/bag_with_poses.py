#!/usr/bin/env python3
"""Writes a bag whose odometry is a trajectory, to draw the map that its poses make of the scans.

    bag_with_poses.py my.bag poses.tum out.bag --scan /scan
    map_bag out.bag --matcher odometry_only --set slam/loop_closing=false --out DIR

Takes the scans of one topic that the trajectory has a pose for, by stamps that agree to 1 ms, and from /tf and
/tf_static what is not of the odometry frame. Poses are of the base, in a TUM file.
"""

import argparse
import sys

import rosbag
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage


class Mistake(Exception):
    """What the user gave is not as it has to be: the text says what, and what would do."""


def read_poses(path):
    """By stamps in ms, as text."""
    try:
        with open(path) as file:
            rows = [[float(word) for word in line.split()] for line in file if line.strip() and line[0] != "#"]
    except OSError as mistake:
        raise Mistake(f"'{path}' cannot be read: {mistake.strerror or mistake}")
    except ValueError:
        rows = []
    if not rows or any(len(row) != 8 for row in rows):
        raise Mistake(f"'{path}' is no TUM file: each line has to be eight numbers, stamp x y z qx qy qz qw")
    return {f"{row[0]:.3f}": row[1:] for row in rows}


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


def main():
    options = parse()
    poses = read_poses(options.poses)
    try:
        with rosbag.Bag(options.bag) as bag, rosbag.Bag(options.out, "w") as out:
            scans = copy(bag, out, poses, options)
    except OSError as mistake:
        raise Mistake(f"'{mistake.filename}': {mistake.strerror}")
    if scans == 0:
        raise Mistake(f"no scan of {options.scan} has a pose in '{options.poses}': stamps have to agree to 1 ms")
    print(f"{options.out}: {scans} scans with their poses")


if __name__ == "__main__":
    try:
        main()
    except (Mistake, rosbag.ROSBagException) as mistake:
        print(f"bag_with_poses.py: {mistake}", file=sys.stderr)
        sys.exit(2)
