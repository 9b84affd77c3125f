#!/usr/bin/env python3
"""Writes a bag with every second, fourth ... scan or beam of a recording, as a lesser laser would have sent it.

    thin_bag.py my.bag out.bag --scan /scan --scans 2
    thin_bag.py my.bag out.bag --scan /scan --beams 4

Takes the scans of one topic, and all of /tf and /tf_static as it is; without --scan the bag's only topic of scans.
"""

import argparse
import sys

try:
    from scan_bag import only_scan_topic, rewrite
except ImportError as error:
    sys.exit(f"thin_bag.py: {error}: it needs ROS's rosbag for this Python, {sys.executable}; "
             "on Debian: apt-get install python3-rosbag, and /usr/bin first in PATH")
from text_rows import Mistake


def with_fewer_beams(scan, every):
    """Every so many, the first one among them."""
    scan.ranges = scan.ranges[::every]
    scan.intensities = scan.intensities[::every]
    scan.angle_increment *= every
    scan.time_increment *= every
    scan.angle_max = scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)
    return scan


def copy(bag, out, topic, scans, beams):
    """The number of scans."""
    seen = 0
    for name, message, time in bag.read_messages(topics=["/tf", "/tf_static", topic]):
        if name == topic:
            seen += 1
            if (seen - 1) % scans:
                continue
            message = with_fewer_beams(message, beams)
        out.write(name, message, time)
    return -(-seen // scans)


def thin(path, target, topic, scans=1, beams=1):
    """The number of scans."""
    return rewrite(path, topic, target, lambda bag, out: copy(bag, out, topic, scans, beams))


def count(text):
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text} is not allowed; allowed: at least 1")
    return number


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag")
    parser.add_argument("out", help="bag to be written")
    parser.add_argument("--scan", help="topic (default: the bag's only one)")
    parser.add_argument("--scans", type=count, default=1, metavar="N", help="every Nth scan")
    parser.add_argument("--beams", type=count, default=1, metavar="N", help="every Nth beam")
    options = parser.parse_args()
    topic = options.scan or only_scan_topic(options.bag) or "/scan"
    print(f"{options.out}: {thin(options.bag, options.out, topic, options.scans, options.beams)} scans")


if __name__ == "__main__":
    try:
        main()
    except Mistake as mistake:
        print(f"thin_bag.py: {mistake}", file=sys.stderr)
        sys.exit(2)
