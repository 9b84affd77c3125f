#!/usr/bin/env python3
"""Draws a matcher's trajectory over that of the odometry, for recordings without a truth."""

import argparse
import os

import numpy

from experiments import NAMES
from plotting import BLUE, VERMILION, finish, legend_above, pyplot, save


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--name', required=True, help='of the matcher')
    parser.add_argument('--trajectory', required=True)
    parser.add_argument('--odometry', required=True)
    parser.add_argument('--out', required=True)
    arguments = parser.parse_args()
    figure, axes = pyplot.subplots(figsize=(8, 8), constrained_layout=True)
    for path, label, style in (
            (arguments.trajectory, NAMES.get(arguments.name, arguments.name), {'color': BLUE}),
            (arguments.odometry, 'odometry', {'color': VERMILION, 'linestyle': '--'})):
        if os.path.getsize(path) == 0:
            continue  # there was no odometry
        poses = numpy.loadtxt(path, ndmin=2)
        axes.plot(poses[:, 1] - poses[0, 1], poses[:, 2] - poses[0, 2], linewidth=1.4, label=label, **style)
    axes.set_aspect('equal', adjustable='datalim')
    finish(axes, 'x from the first pose [m]', 'y from the first pose [m]')
    legend_above(axes)
    save(figure, arguments.out)


if __name__ == '__main__':
    main()
