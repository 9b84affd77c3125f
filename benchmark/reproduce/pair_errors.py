"""The errors of what `match_pairs` wrote: along x and y, as the paper's tables have them, and of the guesses, the
searches' own answers and the refined ones."""

import collections
import csv
import math
import statistics


def read_truth(path):
    """Poses x, y, heading of the base by stamp, in microseconds."""
    poses = {}
    with open(path) as file:
        for line in file:
            if line.strip() and not line.startswith('#'):
                stamp, x, y, _, qx, qy, qz, qw = map(float, line.split())
                heading = math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
                poses[round(1e6 * stamp)] = (x, y, heading)
    return poses


def true_motion(reference, scan):
    """x, y, heading of the second pose in the first."""
    dx, dy, heading = scan[0] - reference[0], scan[1] - reference[1], reference[2]
    return (math.cos(heading) * dx + math.sin(heading) * dy,
            -math.sin(heading) * dx + math.cos(heading) * dy, scan[2] - heading)


def truth_of_pair(truth, row):
    return true_motion(truth[round(1e6 * float(row['reference_stamp']))], truth[round(1e6 * float(row['scan_stamp']))])


def median_errors_mm(pairs_path, truth_path):
    """Medians of the errors along x and y [mm], in the frame of the base at the reference scan."""
    truth = read_truth(truth_path)
    errors_x, errors_y = [], []
    with open(pairs_path) as file:
        for row in csv.DictReader(file):
            x, y, _ = truth_of_pair(truth, row)
            errors_x.append(1000.0 * abs(float(row['x']) - x))
            errors_y.append(1000.0 * abs(float(row['y']) - y))
    return statistics.median(errors_x), statistics.median(errors_y)


# Errors, each a distance [m] and an angle [rad], of one pair; accepted: whether the matcher believes its answer.
Pair = collections.namedtuple('Pair', 'guess search answer accepted')


def error_of(row, name, truth):
    x, y, heading = (float(row[name + key]) - true for key, true in zip(('x', 'y', 'theta'), truth))
    return math.hypot(x, y), abs(math.remainder(heading, 2.0 * math.pi))


def read_pairs(pairs_path, truth_path, matcher):
    """The errors of all pairs that a matcher was asked for."""
    truth = read_truth(truth_path)
    with open(pairs_path) as file:
        return [Pair(*(error_of(row, name, truth_of_pair(truth, row)) for name in ('guess_', 'search_', '')),
                     row['status'] == 'accepted')
                for row in csv.DictReader(file) if row['matcher'] == matcher]


def is_found(error, limits):
    return error[0] <= limits[0] and error[1] <= limits[1]


def found_shares(pairs, limits):
    """The shares of pairs whose searches' own answers, and whose refined ones, are within the limits; none of no
    pairs. What a matcher does not believe itself is not found."""
    if not pairs:
        return None
    return {name: sum(pair.accepted and is_found(getattr(pair, name), limits) for pair in pairs) / len(pairs)
            for name in ('search', 'answer')}


def found_by_guess(pairs, limits, far, bins):
    """The same for pairs whose guess is off by up to a tenth of `far` [m], by up to two tenths and so on, if there
    are ten bins."""
    parts = [[] for _ in range(bins)]
    for pair in pairs:
        parts[min(bins - 1, int(bins * pair.guess[0] / far))].append(pair)
    return [found_shares(part, limits) for part in parts]


def median(pairs, name):
    """The median errors of the pairs, in mm and mrad."""
    return [1000.0 * statistics.median(getattr(pair, name)[i] for pair in pairs) for i in (0, 1)]
