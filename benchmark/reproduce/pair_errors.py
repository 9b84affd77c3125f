"""The errors along x and y of what `match_pairs` wrote, as the paper's tables have them."""

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
    """x, y of the second pose in the first."""
    dx, dy, heading = scan[0] - reference[0], scan[1] - reference[1], reference[2]
    return (math.cos(heading) * dx + math.sin(heading) * dy,
            -math.sin(heading) * dx + math.cos(heading) * dy)


def median_errors_mm(pairs_path, truth_path):
    """Medians of the errors along x and y [mm], in the frame of the base at the reference scan."""
    truth = read_truth(truth_path)
    errors_x, errors_y = [], []
    with open(pairs_path) as file:
        for row in csv.DictReader(file):
            x, y = true_motion(truth[round(1e6 * float(row['reference_stamp']))],
                               truth[round(1e6 * float(row['scan_stamp']))])
            errors_x.append(1000.0 * abs(float(row['x']) - x))
            errors_y.append(1000.0 * abs(float(row['y']) - y))
    return statistics.median(errors_x), statistics.median(errors_y)
