#!/usr/bin/env python3
"""Draws maps that map_server reads, with axes in metres."""

import argparse
import os

import numpy
import yaml
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from plotting import finish, legend_above, pyplot, save

OCCUPIED, UNKNOWN, FREE = 0, 1, 2
COLORS = ('#000000', '#B8C4CE', '#FFFFFF')


def read_map(path):
    """Classes of the cells, the first row at the bottom, and the extent in metres as imshow has it."""
    with open(path) as file:
        description = yaml.safe_load(file)
    grey = pyplot.imread(os.path.join(os.path.dirname(path), description['image']))
    occupancy = (255.0 - numpy.flipud(grey)) / 255.0
    cells = numpy.full(grey.shape, UNKNOWN)
    cells[occupancy > description['occupied_thresh']] = OCCUPIED
    cells[occupancy < description['free_thresh']] = FREE
    x, y, resolution = description['origin'][0], description['origin'][1], description['resolution']
    return cells, (x, x + resolution * cells.shape[1], y, y + resolution * cells.shape[0])


def extent_of_known(maps):
    """What holds the known cells of all maps, so that they are drawn alike."""
    boxes = []
    for cells, (left, right, bottom, top) in maps:
        rows, columns = numpy.nonzero(cells != UNKNOWN)
        cell = (right - left) / cells.shape[1]
        boxes.append((left + cell * columns.min(), left + cell * (columns.max() + 1),
                      bottom + cell * rows.min(), bottom + cell * (rows.max() + 1)))
    boxes = numpy.array(boxes)
    return boxes[:, 0].min() - 0.5, boxes[:, 1].max() + 0.5, boxes[:, 2].min() - 0.5, boxes[:, 3].max() + 0.5


def draw_map(cells, extent, window, path):
    figure, axes = pyplot.subplots(figsize=(7, 7), constrained_layout=True)
    axes.set_facecolor(COLORS[UNKNOWN])
    axes.imshow(cells, cmap=ListedColormap(COLORS), vmin=0, vmax=2, origin='lower', extent=extent,
                interpolation='antialiased')
    axes.set_xlim(window[0], window[1])
    axes.set_ylim(window[2], window[3])
    finish(axes, 'x [m]', 'y [m]')
    axes.grid(False)
    handles = [Patch(facecolor=color, edgecolor='black', label=label)
               for color, label in zip(COLORS, ('occupied', 'unknown', 'free'))]
    legend_above(axes, 3, handles=handles)
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--map', nargs='+', required=True, help='map.yaml files')
    parser.add_argument('--out', nargs='+', required=True, help='one picture a map')
    arguments = parser.parse_args()
    maps = [read_map(path) for path in arguments.map]
    window = extent_of_known(maps)
    for (cells, extent), path in zip(maps, arguments.out):
        draw_map(cells, extent, window, path)


if __name__ == '__main__':
    main()
