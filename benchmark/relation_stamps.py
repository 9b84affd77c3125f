#!/usr/bin/env python3
"""How much of an error against verified relations is that of their stamps.

    relation_stamps.py ours.tum --relations intel.relations --odometry intel.odom.tum

A relation says how two scans lie to each other; where they were taken has to be looked up by their stamps. Where a log
wrote down many poses at once, its odometry goes from one to the next faster than any robot, and a stamp does not tell
which of them is meant. So relations are told apart by the fastest step of odometry within --within of one of their two
stamps. The error of a relation is as of `evaluate relations`: between its poses the estimate is carried by odometry.
"""

import argparse
import bisect
import json
import math
import sys

from text_rows import TUM, Mistake, read_rows

LIMITS = (0.0, 2.0, 20.0, math.inf)  # m/s, of the fastest step
SHORTEST = 1e-4  # s that a step takes at least, of stamps that are the same
FARTHEST = 0.5  # s from a stamp to the odometry that is looked up for it


def compose(a, b):
    c, s = math.cos(a[2]), math.sin(a[2])
    return a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]


def inverse(a):
    c, s = math.cos(a[2]), math.sin(a[2])
    return -c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]


def blend(a, b, share):
    """From a to b, of the turn the shorter way."""
    turn = math.remainder(b[2] - a[2], 2.0 * math.pi)
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * turn


class Trajectory:
    def __init__(self, path):
        rows = read_rows(path, 8, TUM)
        rows.sort(key=lambda row: row[0])
        self.stamps = [row[0] for row in rows]
        self.poses = [(row[1], row[2], 2.0 * math.atan2(row[6], row[7])) for row in rows]

    def around(self, stamp):
        """Numbers of the poses before and after; both the same at an end."""
        after = bisect.bisect_left(self.stamps, stamp)
        return max(0, after - 1), min(len(self.stamps) - 1, after)

    def at(self, stamp):
        """Interpolated; none where no pose is near."""
        before, after = self.around(stamp)
        if min(abs(self.stamps[i] - stamp) for i in (before, after)) > FARTHEST:
            return None
        length = self.stamps[after] - self.stamps[before]
        share = min(1.0, max(0.0, (stamp - self.stamps[before]) / length)) if length > 0.0 else 0.0
        return blend(self.poses[before], self.poses[after], share)

    def fastest(self, begin, end):
        """[m/s] of the steps from the pose before a time to the one after another."""
        first = max(0, bisect.bisect_left(self.stamps, begin) - 1)
        last = min(len(self.stamps) - 1, bisect.bisect_right(self.stamps, end))
        return max((math.dist(self.poses[i][:2], self.poses[i + 1][:2])
                    / max(SHORTEST, self.stamps[i + 1] - self.stamps[i]) for i in range(first, last)), default=0.0)


def carried(estimate, odometry, stamp):
    """The estimate before and the one after, each carried to a stamp by odometry, the nearer the more."""
    there = odometry.at(stamp)
    before, after = estimate.around(stamp)
    from_odometry = [odometry.at(estimate.stamps[i]) for i in (before, after)]
    if there is None or None in from_odometry:
        return None
    a, b = (compose(estimate.poses[i], compose(inverse(odom), there))
            for i, odom in zip((before, after), from_odometry))
    length = estimate.stamps[after] - estimate.stamps[before]
    return blend(a, b, (stamp - estimate.stamps[before]) / length if length > 0.0 else 0.0)


def errors_by_speed(estimate, odometry, relations, within):
    """(fastest step [m/s], error [m]) of each relation that can be looked up."""
    for first, second, x, y, _, _, _, yaw in relations:
        poses = [carried(estimate, odometry, stamp) for stamp in (first, second)]
        if None not in poses:
            error = compose(inverse((x, y, yaw)), compose(inverse(poses[0]), poses[1]))
            yield max(odometry.fastest(t - within, t + within) for t in (first, second)), math.hypot(*error[:2])


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("estimate", help="TUM file")
    parser.add_argument("--relations", required=True, help="lines of stamp1 stamp2 x y z roll pitch yaw")
    parser.add_argument("--odometry", required=True, help="TUM file of raw odometry")
    parser.add_argument("--within", type=float, default=0.5, help="s (default: %(default)s)")
    return parser.parse_args()


def main():
    options = parse()
    if not options.within >= 0.0:
        raise Mistake(f"--within: {options.within:g} is not allowed; allowed: 0 and more")
    relations = read_rows(options.relations, 8, "file of relations: each line has to be eight numbers")
    errors = list(errors_by_speed(Trajectory(options.estimate), Trajectory(options.odometry), relations, options.within))
    if not errors:
        raise Mistake(f"odometry has no pose within {FARTHEST:g} s of the stamps of any relation")
    for least, most in [(0.0, math.inf)] + list(zip(LIMITS, LIMITS[1:])):
        some = sorted(error for speed, error in errors if least <= speed < most)
        if some:
            print(json.dumps({"fastest_from_m_s": least, "fastest_to_m_s": most if most < math.inf else None,
                              "relations": len(some), "mean_m": round(sum(some) / len(some), 4),
                              "median_m": round(some[len(some) // 2], 4)}))


if __name__ == "__main__":
    try:
        main()
    except Mistake as mistake:
        print(f"relation_stamps.py: {mistake}", file=sys.stderr)
        sys.exit(2)
