#!/usr/bin/env python3
"""Draws, in the folder of a run, the measured times of table I and the power laws fitted to them."""

import argparse

import numpy
from matplotlib.ticker import EngFormatter, FormatStrFormatter, LogLocator, NullFormatter

from experiments import NAMES
from exponents import evaluate
from files import read_json
from plotting import BLUE, VERMILION, finish, legend_above, pyplot, save
from tables import exponent


def label_ticks(axis, formatter):
    """1, 2, 5, 10 and so on, in plain numbers: few axes here span many decades."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(formatter)
    axis.set_minor_formatter(NullFormatter())


def draw(axes, row):
    x = numpy.asarray(row['x'], float)
    axes.plot(x, row['time_ms'], 'o', color=BLUE, label='measured, median')
    curve = numpy.geomspace(x.min(), x.max(), 100)
    axes.plot(curve, evaluate(row['fit'], curve, x.max()), color=VERMILION,
              label='%.2f ms + b x$^k$, k = %s' % (row['fit']['fixed'], exponent(row['fit'])))
    axes.set_xscale('log')
    axes.set_yscale('log')
    # A whole decade at least, so that flat looks flat and numbers have room.
    middle = numpy.sqrt(min(row['time_ms']) * max(row['time_ms']))
    axes.set_ylim(min(middle / 4.0, 0.8 * min(row['time_ms'])), max(middle * 4.0, 1.25 * max(row['time_ms'])))
    label_ticks(axes.xaxis, EngFormatter(sep=''))
    label_ticks(axes.yaxis, FormatStrFormatter('%g'))
    finish(axes, 'x = $%s$ [%s]' % (row['quantity'].replace('·', r'\cdot').replace(
        'tries', r'\mathrm{tries}'), row['unit']), 'time of a match [ms]')
    axes.set_title(NAMES[row['matcher']], loc='left', pad=52, fontweight='bold')
    legend_above(axes, 1)


def main():
    argparse.ArgumentParser(description=__doc__).parse_args()
    rows = read_json('times.json')['complexity']
    figure, panels = pyplot.subplots((len(rows) + 1) // 2, 2, figsize=(10, 13), squeeze=False,
                                     constrained_layout=True)
    for axes, row in zip(panels.flat, rows):
        if 'failed' in row:
            axes.set_title('%s: failed' % NAMES[row['matcher']], loc='left')
        else:
            draw(axes, row)
    save(figure, 'figures/1_complexity.png')


if __name__ == '__main__':
    main()
