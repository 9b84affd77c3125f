#!/usr/bin/env python3
"""Draws maps that map_server reads, with axes in metres."""

import argparse
import os

import numpy
import yaml
from matplotlib.colors import to_rgb
from matplotlib.patches import Patch

from plotting import finish, legend_above, pyplot, save

# By rank: what is the first among the cells that share a pixel is seen.
OCCUPIED, FREE, UNKNOWN = 0, 1, 2
COLORS = ('#000000', '#FFFFFF', '#B8C4CE')
LABELS = ('occupied', 'free', 'unknown')
# Fewer than the pixels of a figure.
MOST_CELLS = 480


def read_map(path):
    """Classes of the cells, the first row at the bottom, the origin [m] and the side of a cell [m]."""
    with open(path) as file:
        description = yaml.safe_load(file)
    grey = pyplot.imread(os.path.join(os.path.dirname(path), description['image']))
    occupancy = (255.0 - numpy.flipud(grey)) / 255.0
    cells = numpy.full(grey.shape, UNKNOWN)
    cells[occupancy > description['occupied_thresh']] = OCCUPIED
    cells[occupancy < description['free_thresh']] = FREE
    return cells, tuple(description['origin'][:2]), description['resolution']


def extent_of_known(maps):
    """What holds the known cells of all maps, so that they are drawn alike."""
    boxes = []
    for cells, (left, bottom), cell in maps:
        rows, columns = numpy.nonzero(cells != UNKNOWN)
        boxes.append((left + cell * columns.min(), left + cell * (columns.max() + 1),
                      bottom + cell * rows.min(), bottom + cell * (rows.max() + 1)))
    boxes = numpy.array(boxes)
    return boxes[:, 0].min() - 0.5, boxes[:, 1].max() + 0.5, boxes[:, 2].min() - 0.5, boxes[:, 3].max() + 0.5


def crop(cells, origin, side, window):
    """The part of a map that the window shows."""
    first = [max(0, int((window[2 * i] - origin[i]) / side)) for i in (0, 1)]
    last = [max(first[i] + 1, int(numpy.ceil((window[2 * i + 1] - origin[i]) / side))) for i in (0, 1)]
    return (cells[first[1]:last[1], first[0]:last[0]],
            (origin[0] + side * first[0], origin[1] + side * first[1]))


def shrink(cells, factor):
    """Squares of cells as one, of their first class by rank: a wall one cell thick stays black."""
    rows, columns = (-(-size // factor) for size in cells.shape)
    padded = numpy.full((rows * factor, columns * factor), UNKNOWN)
    padded[:cells.shape[0], :cells.shape[1]] = cells
    return padded.reshape(rows, factor, columns, factor).min(axis=(1, 3))


def draw_map(cells, origin, side, window, path):
    cells, (left, bottom) = crop(cells, origin, side, window)
    factor = -(-max(cells.shape) // MOST_CELLS)
    cells, side = shrink(cells, factor), side * factor
    figure, axes = pyplot.subplots(figsize=(7, 7), constrained_layout=True)
    axes.set_facecolor(COLORS[UNKNOWN])
    axes.imshow(numpy.array([to_rgb(color) for color in COLORS])[cells], origin='lower', interpolation='nearest',
                extent=(left, left + side * cells.shape[1], bottom, bottom + side * cells.shape[0]))
    axes.set_xlim(window[0], window[1])
    axes.set_ylim(window[2], window[3])
    finish(axes, 'x [m]', 'y [m]')
    axes.grid(False)
    handles = [Patch(facecolor=color, edgecolor='black', label=label)
               for color, label in zip(COLORS, LABELS)]
    legend_above(axes, 3, handles=handles)
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--map', nargs='+', required=True, help='map.yaml files')
    parser.add_argument('--out', nargs='+', required=True, help='one picture a map')
    arguments = parser.parse_args()
    # Where a map failed, the others are drawn all the same.
    maps = [(read_map(path), out) for path, out in zip(arguments.map, arguments.out) if os.path.exists(path)]
    maps = [(read, out) for read, out in maps if (read[0] != UNKNOWN).any()]
    window = extent_of_known([read for read, _ in maps]) if maps else None
    for read, out in maps:
        draw_map(*read, window, out)


if __name__ == '__main__':
    main()
