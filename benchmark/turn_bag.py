#!/usr/bin/env python3
"""Writes a bag of a recording as another drive: backwards, mirrored, or a part of it.

    turn_bag.py my.bag out.bag --backwards
    turn_bag.py my.bag out.bag --mirrored --begin 0.33
    turn_bag.py my.bag out.bag --backwards --truth my.tum out.tum

Real walls and real noise, on a way that nothing was chosen on. Takes the scans of one topic, /tf and /tf_static.
Backwards, the last scan has the stamp of the first one; a sweep would turn the other way round then, so that the scans'
beams have to be taken at once (time_increment 0).
"""

import argparse
import copy
import math
import sys

try:
    import genpy

    from scan_bag import only_scan_topic, rewrite
except ImportError as error:
    sys.exit(f"turn_bag.py: {error}: it needs ROS's rosbag for this Python, {sys.executable}; "
             "on Debian: apt-get install python3-rosbag, and /usr/bin first in PATH")
from text_rows import TUM, Mistake, read_rows

MARGIN = 2.0  # [s] of tf before the first scan and behind the last one


class Turn:
    """How stamps and poses of a recording are those of another drive."""

    def __init__(self, first, last, backwards, mirrored, begin, end):
        self.both_ends = first + last
        self.first = first + int(begin * (last - first))  # [ns], as all stamps
        self.last = first + int(end * (last - first))
        self.backwards, self.mirrored = backwards, mirrored

    def is_taken(self, stamp, margin=0.0):
        return self.first - margin * 1e9 <= stamp <= self.last + margin * 1e9

    def stamp(self, stamp):
        return self.both_ends - stamp if self.backwards else stamp

    def time(self, time):
        return genpy.Time(0, self.stamp(time.to_nsec()))

    def scan(self, message):
        message.header.stamp = self.time(message.header.stamp)
        if self.mirrored:
            message.ranges, message.intensities = message.ranges[::-1], message.intensities[::-1]
            message.angle_min, message.angle_max = -message.angle_max, -message.angle_min
        return message

    def transforms(self, message, is_static):
        for link in message.transforms:
            if not is_static:
                link.header.stamp = self.time(link.header.stamp)
            if self.mirrored:  # at the plane y = 0
                link.transform.translation.y *= -1.0
                link.transform.rotation.x *= -1.0
                link.transform.rotation.z *= -1.0
        return message

    def row(self, stamp, x, y, yaw):
        """Of a trajectory, by seconds."""
        turned = (self.both_ends / 1e9 - stamp) if self.backwards else stamp
        return (turned, x, -y, -yaw) if self.mirrored else (turned, x, y, yaw)


def turn_of(bag, topic, options):
    stamps = []
    for _, scan, _ in bag.read_messages(topics=[topic]):
        stamps.append(scan.header.stamp.to_nsec())
        if options.backwards and scan.time_increment != 0.0:
            raise Mistake(f"--backwards: scans on '{topic}' have a time_increment of {scan.time_increment:g} s; allowed: 0")
    return Turn(min(stamps), max(stamps), options.backwards, options.mirrored, options.begin, options.end)


def turned(bag, topic, turn):
    """Messages in the order of their new times, transforms before scans."""
    rows = []
    for name, message, time in bag.read_messages(topics=["/tf", "/tf_static", topic]):
        message = copy.deepcopy(message)
        if name == topic:
            if turn.is_taken(message.header.stamp.to_nsec()):
                rows.append((turn.time(time), 1, name, turn.scan(message)))
        elif name == "/tf_static":
            start = min(turn.stamp(turn.first), turn.stamp(turn.last)) - int(MARGIN * 1e9)
            rows.append((genpy.Time(0, max(1, start)), -1, name, turn.transforms(message, True)))
        elif turn.is_taken(message.transforms[0].header.stamp.to_nsec(), MARGIN):
            rows.append((turn.time(time), 0, name, turn.transforms(message, False)))
    return sorted(rows, key=lambda row: row[:2])


def write_truth(path, target, turn):
    rows = sorted(turn.row(row[0], row[1], row[2], 2.0 * math.atan2(row[6], row[7])) for row in read_rows(path, 8, TUM))
    with open(target, "w") as file:
        for stamp, x, y, yaw in rows:
            file.write(f"{stamp:.6f} {x:.9f} {y:.9f} 0 0 0 {math.sin(0.5 * yaw):.12f} {math.cos(0.5 * yaw):.12f}\n")


def write(bag, out, topic, options):
    """The number of scans."""
    turn = turn_of(bag, topic, options)
    rows = turned(bag, topic, turn)
    scans = sum(name == topic for _, _, name, _ in rows)
    if scans == 0:
        raise Mistake(f"--begin {options.begin:g} --end {options.end:g}: no scan of '{topic}' is between")
    for time, _, name, message in rows:
        out.write(name, message, time)
    if options.truth:
        write_truth(*options.truth, turn)
    return scans


def share(text):
    number = float(text)
    if not 0.0 <= number <= 1.0:
        raise argparse.ArgumentTypeError(f"{text} is not allowed; allowed: 0 to 1")
    return number


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag")
    parser.add_argument("out", help="bag to be written")
    parser.add_argument("--scan", help="topic (default: the bag's only one)")
    parser.add_argument("--backwards", action="store_true", help="the last scan first")
    parser.add_argument("--mirrored", action="store_true", help="left for right")
    parser.add_argument("--begin", type=share, default=0.0, help="share of its time that is left out before (0)")
    parser.add_argument("--end", type=share, default=1.0, help="share of its time at which it ends (1)")
    parser.add_argument("--truth", nargs=2, metavar=("TUM", "OUT"), help="a trajectory, which is turned likewise")
    options = parser.parse_args()
    topic = options.scan or only_scan_topic(options.bag) or "/scan"
    scans = rewrite(options.bag, topic, options.out, lambda bag, out: write(bag, out, topic, options))
    print(f"{options.out}: {scans} scans")


if __name__ == "__main__":
    try:
        main()
    except Mistake as mistake:
        print(f"turn_bag.py: {mistake}", file=sys.stderr)
        sys.exit(2)
