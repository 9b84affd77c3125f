#!/usr/bin/env python3
"""Draws figures 2 to 5: a scan and the robot, the lookup table with the next scan over it, lines in the
Hough domain, and the Hough domain of the scan."""

import argparse

import numpy

import hough
import scans
from files import read_json
from plotting import BLUE, GREEN, VERMILION, finish, legend_above, pyplot, save

# Scans between the one that makes the table and the one that is laid over it, as in match_pairs.
GAP = 10
# How far the prediction of figure 3 is off: x, y [m] and heading [rad], within the bounds of tests B and D.
PREDICTION_ERROR = (0.15, -0.2, 0.15)
COLUMNS, CELL = 180, 0.03
TABLE_CELL = 0.02


def read_trajectory(path):
    """Stamp, x, y, heading of each pose."""
    columns = numpy.loadtxt(path, ndmin=2)
    return numpy.column_stack([columns[:, :3], 2.0 * numpy.arctan2(columns[:, 6], columns[:, 7])])


def between(reference, pose):
    """The second pose in the first."""
    dx, dy, heading = pose[0] - reference[0], pose[1] - reference[1], reference[2]
    return (numpy.cos(heading) * dx + numpy.sin(heading) * dy,
            -numpy.sin(heading) * dx + numpy.cos(heading) * dy, pose[2] - heading)


def moved(points, pose):
    cosine, sine = numpy.cos(pose[2]), numpy.sin(pose[2])
    return points @ numpy.array([[cosine, sine], [-sine, cosine]]) + pose[:2]


def draw_robot(axes, pose=(0.0, 0.0, 0.0)):
    outline = moved(numpy.array([[0.3, 0.0], [-0.2, 0.2], [-0.2, -0.2]]), pose)
    axes.fill(outline[:, 0], outline[:, 1], color=VERMILION, zorder=5, label='robot, pointing ahead')


def reach_of(points):
    """Half the side of a square that holds nearly all points: a few beams through a door may go far."""
    return 1.15 * numpy.percentile(numpy.abs(points).max(axis=1), 95)


def plan(reach):
    """A square look from above."""
    figure, axes = pyplot.subplots(figsize=(7, 7.4), constrained_layout=True)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_aspect('equal')
    return figure, axes


def draw_scan(points, laser, path):
    figure, axes = plan(reach_of(points))
    ends = points[::8]
    axes.plot(numpy.stack([numpy.full(len(ends), laser[0]), ends[:, 0]]),
              numpy.stack([numpy.full(len(ends), laser[1]), ends[:, 1]]), color='#DDDDDD', linewidth=0.6)
    axes.plot([], [], color='#BBBBBB', label='every eighth beam')
    axes.plot(points[:, 0], points[:, 1], '.', color=BLUE, markersize=4, label='scan, %d hits' % len(points))
    draw_robot(axes)
    finish(axes, 'x of the base [m]', 'y of the base [m]')
    legend_above(axes, 3)
    save(figure, path)


def lookup_table(points, reach, sigma):
    """The likelihood of a hit, [y, x]: the Gaussian around the nearest point."""
    size = round(2.0 * reach / TABLE_CELL)
    table = numpy.zeros((size, size))
    radius = int(numpy.ceil(3.0 * sigma / TABLE_CELL))
    for x, y in (points + reach) / TABLE_CELL - 0.5:
        column, row = int(round(x)), int(round(y))
        if radius <= column < size - radius and radius <= row < size - radius:
            across = numpy.arange(-radius, radius + 1)
            patch = numpy.exp(-0.5 * (TABLE_CELL / sigma) ** 2 * numpy.add.outer(
                (across + row - y) ** 2, (across + column - x) ** 2))
            part = table[row - radius:row + radius + 1, column - radius:column + radius + 1]
            numpy.maximum(part, patch, out=part)
    return table


def draw_lookup_table(reference, scan, motion, sigma, path):
    reach = min(6.0, reach_of(reference))
    figure, axes = plan(reach)
    image = axes.imshow(lookup_table(reference, reach, sigma), cmap='Greys', origin='lower',
                        extent=(-reach, reach, -reach, reach), interpolation='nearest', vmin=0, vmax=1)
    figure.colorbar(image, ax=axes, location='bottom', shrink=0.7, aspect=30, label='likelihood of a hit')
    predicted = numpy.add(motion, PREDICTION_ERROR)
    for pose, color, label in ((predicted, VERMILION, 'new scan, off by %.2f m, %.2f rad' % (
            numpy.hypot(*PREDICTION_ERROR[:2]), PREDICTION_ERROR[2])),
                               (motion, BLUE, 'new scan, matched')):
        at = moved(scan, pose)[::4]
        axes.plot(at[:, 0], at[:, 1], '.', color=color, markersize=3.5, label=label)
    finish(axes, 'x of the base at the reference scan [m]', 'y [m]')
    axes.grid(False)
    legend_above(axes, 1)
    save(figure, path)


def strongest_line(points):
    """Normal's angle and distance of the line that most points vote for."""
    votes, edges = hough.domain(points, COLUMNS, CELL)
    row, column = numpy.unravel_index(votes.argmax(), votes.shape)
    return column * numpy.pi / COLUMNS, 0.5 * (edges[row] + edges[row + 1])


def draw_hough_lines(points, path):
    """Three points of the strongest line: where they lie, and their sinusoids, which meet in that line."""
    angle, distance = strongest_line(points)
    on_line = points[numpy.abs(hough.rho(points.T, angle) - distance) < CELL]
    along = on_line @ numpy.array([-numpy.sin(angle), numpy.cos(angle)])
    chosen = on_line[numpy.argsort(along)[[0, len(along) // 2, -1]]]
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(11, 5.2), constrained_layout=True)
    left.plot(points[:, 0], points[:, 1], '.', color='#BBBBBB', markersize=3, label='scan')
    normal = distance * numpy.array([numpy.cos(angle), numpy.sin(angle)])
    left.plot([0.0, normal[0]], [0.0, normal[1]], color='black', linewidth=1.2,
              label='ρ = %.2f m, θ = %.0f°' % (distance, numpy.degrees(angle)))
    angles = numpy.linspace(0.0, numpy.pi, 361)
    for number, (point, color) in enumerate(zip(chosen, (BLUE, VERMILION, GREEN)), start=1):
        left.plot(*point, 'o', color=color, markersize=8, label='point %d' % number)
        right.plot(numpy.degrees(angles), hough.rho(point, angles), color=color, linewidth=1.8,
                   label='lines through point %d' % number)
    right.plot(numpy.degrees(angle), distance, 'o', color='black', fillstyle='none', markersize=13,
               label='the line through all')
    reach = reach_of(points)
    left.set_xlim(-reach, reach)
    left.set_ylim(-reach, reach)
    left.set_aspect('equal')
    finish(left, 'x of the base [m]', 'y of the base [m]')
    finish(right, 'θ, direction of the normal [°]', 'ρ, distance from the origin [m]')
    right.set_xlim(0, 180)
    right.set_xticks(range(0, 181, 30))
    legend_above(left, 2)
    legend_above(right, 2)
    save(figure, path)


def draw_hough_domain(points, path):
    votes, edges = hough.domain(points, COLUMNS, CELL)
    half = 90.0 / COLUMNS  # of a column, whose angle is its middle [degrees]
    figure, (above, below) = pyplot.subplots(
        2, 1, figsize=(11, 7.5), sharex=True, gridspec_kw={'height_ratios': (3, 1)}, constrained_layout=True)
    image = above.imshow(votes, aspect='auto', origin='lower', extent=(-half, 180 - half, edges[0], edges[-1]),
                         cmap='magma_r', interpolation='nearest', vmax=max(1, votes.max() / 3))
    figure.colorbar(image, ax=above, label='votes of points', extend='max')
    finish(above, '', 'ρ, distance from the origin [m]')
    above.grid(False)
    reach = 1.15 * numpy.percentile(numpy.hypot(points[:, 0], points[:, 1]), 95)
    above.set_ylim(max(edges[0], -reach), min(edges[-1], reach))
    angles = numpy.arange(COLUMNS) * 180.0 / COLUMNS
    below.plot(angles, (votes.astype(float) ** 2).sum(axis=0), color=BLUE, label='spectrum: sum of squares')
    finish(below, 'θ, direction of the normal [°]', 'votes²')
    below.set_ylim(bottom=0)
    below.set_xticks(range(0, 181, 30))
    legend_above(below)
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--report', required=True, help='report.json of map_bag')
    parser.add_argument('--trajectory', required=True)
    parser.add_argument('--bag', nargs='+', required=True)
    parser.add_argument('--out', nargs=4, required=True)
    arguments = parser.parse_args()
    report = read_json(arguments.report)
    poses = read_trajectory(arguments.trajectory)
    first = len(poses) // 2
    second = min(first + GAP, len(poses) - 1)
    messages = scans.read_messages(arguments.bag, report['scan_topic'].split(', '),
                                   [poses[first, 0], poses[second, 0]], report['scan_time_offset_s'])
    # Each of several lasers has its own place.
    mounts = [scans.laser_mount(arguments.bag, report['frames']['base'], message.header.frame_id)
              for message in messages]
    reference, scan = map(scans.points, messages, mounts)
    draw_scan(reference, mounts[0][1], arguments.out[0])
    draw_lookup_table(reference, scan, between(poses[first, 1:], poses[second, 1:]),
                      report['configuration']['field/sigma'], arguments.out[1])
    draw_hough_lines(reference, arguments.out[2])
    draw_hough_domain(reference, arguments.out[3])


if __name__ == '__main__':
    main()
