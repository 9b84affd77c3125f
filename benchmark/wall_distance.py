#!/usr/bin/env python3
"""How far scan points lie from the walls that other passes saw, by several trajectories.

    wall_distance.py my.bag --scan /scan ours.tum theirs.tum

Where a robot comes by again, what it sees now has to lie on what it saw then. No truth is needed for that, so it also
says how good poses are that are called the truth. Of each scan's points: the distance to the nearest point of any scan
taken at least `--apart` scans before or after, where there is one within `--reach`; farther ones are new ground, or
doubled walls, and are counted.
"""

import argparse
import json
import math
import sys

try:
    import numpy as np
    import rosbag
    from scipy.spatial import cKDTree

    from scan_bag import open_scan_bag
except ImportError as error:
    sys.exit(f"wall_distance.py: {error}: it needs NumPy, SciPy and ROS's rosbag for this Python, {sys.executable}; "
             "on Debian: apt-get install python3-scipy python3-rosbag, and /usr/bin first in PATH")
from text_rows import TUM, Mistake, read_rows


def read_scans(path, topic):
    with open_scan_bag(path, topic) as bag:
        for _, message, _ in bag.read_messages(topics=[topic]):
            ranges = np.asarray(message.ranges)
            angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
            good = (ranges > message.range_min) & (ranges < min(message.range_max, 30.0))
            yield message.header.stamp.to_sec(), np.column_stack(
                (ranges * np.cos(angles), ranges * np.sin(angles)))[good]


def place(points, pose):
    x, y, theta = pose
    turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    return points @ turn.T + (x, y)


def read_poses(path):
    rows = np.array(read_rows(path, 8, TUM))
    theta = 2.0 * np.arctan2(rows[:, 6], rows[:, 7])
    return {f"{stamp:.3f}": (x, y, t) for stamp, x, y, t in zip(rows[:, 0], rows[:, 1], rows[:, 2], theta)}


def wall_distances(scans, poses, mount, apart, reach):
    """[m] of each point that has an older or later one within reach, and the number of those that have none."""
    placed = [place(place(points, mount), poses[stamp]) for stamp, points in scans]
    number = np.concatenate([np.full(len(points), i) for i, points in enumerate(placed)])
    points = np.concatenate(placed)
    near = np.full(len(points), np.inf)
    block = 50  # scans that are left out of the tree at once, with those near them in time
    for begin in range(0, len(placed), block):
        mine = (number >= begin) & (number < begin + block)
        others = (number < begin - apart) | (number >= begin + block + apart)
        if others.any() and mine.any():
            near[mine] = cKDTree(points[others]).query(points[mine], distance_upper_bound=reach)[0]
    return near[np.isfinite(near)], int(np.isinf(near).sum())


def number(least, what):
    """Of a positive or a finite number, for argparse."""
    def read(text):
        value = float(text)
        if not (math.isfinite(value) and value > least):
            raise argparse.ArgumentTypeError(f"{text} is not allowed; allowed: {what}")
        return value
    return read


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag")
    parser.add_argument("trajectories", nargs="+", help="TUM files of the base")
    parser.add_argument("--scan", default="/scan", help="topic (default: %(default)s)")
    parser.add_argument("--mount", type=number(-math.inf, "finite numbers"), nargs=3, default=(0.0, 0.0, 0.0), 
                        metavar=("X", "Y", "THETA"), help="pose of the laser on the base [m, rad]")
    parser.add_argument("--apart", type=number(0, "above 0"), default=100, help="scans (default: %(default)s)")
    parser.add_argument("--reach", type=number(0, "above 0"), default=1.0, help="m (default: %(default)s)")
    return parser.parse_args()


def main():
    options = parse()
    all_poses = [read_poses(path) for path in options.trajectories]
    scans = [(f"{stamp:.3f}", points) for stamp, points in read_scans(options.bag, options.scan)]
    scans = [scan for scan in scans if all(scan[0] in poses for poses in all_poses)]
    if not scans:
        raise Mistake(f"no scan of {options.scan} has a pose in every trajectory: stamps have to agree to 1 ms")
    for path, poses in zip(options.trajectories, all_poses):
        distances, alone = wall_distances(scans, poses, options.mount, options.apart, options.reach)
        if not len(distances):
            raise Mistake(f"no point of '{path}' lies within --reach {options.reach:g} m of one that was seen "
                          f"--apart {options.apart:g} scans before or after: the robot did not come by again")
        print(json.dumps({"trajectory": path, "scans": len(scans), "points": len(distances), "alone": alone,
                          "mean_m": round(float(distances.mean()), 4),
                          "median_m": round(float(np.median(distances)), 4),
                          "p90_m": round(float(np.percentile(distances, 90)), 4)}))


if __name__ == "__main__":
    try:
        main()
    except (Mistake, rosbag.ROSBagException) as mistake:
        print(f"wall_distance.py: {mistake}", file=sys.stderr)
        sys.exit(2)
