#!/usr/bin/env python3
"""Draws, in the folder of a run, how often each matcher finds the truth against how wrong the guess was."""

import argparse

from experiments import BASIN_BINS, BASINS, FAR, MATCHERS, NAMES
from files import read_json
from plotting import BLUE, GREEN, VERMILION, finish, pyplot, save

COLORS = dict(zip(MATCHERS, (VERMILION, BLUE, GREEN)))
# Below others the line is wide, so that both show where they are the same.
WIDTHS = dict(zip(MATCHERS, (1.6, 4.5, 1.6)))
SEARCH, ANSWER = {'linestyle': '--'}, {'linestyle': '-', 'marker': 'o', 'markersize': 3}


def draw(axes, row):
    middles = [FAR[0] * (i + 0.5) / BASIN_BINS for i in range(BASIN_BINS)]
    for name, style in (('search', SEARCH), ('answer', ANSWER)):
        axes.plot(middles, [None if found is None else 100.0 * found[name] for found in row['found']],
                  color=COLORS[row['matcher']], linewidth=WIDTHS[row['matcher']], **style)


def main():
    argparse.ArgumentParser(description=__doc__).parse_args()
    rows = [row for row in read_json('summary.json')['basins'] if 'failed' not in row]
    figure, panels = pyplot.subplots(2, 2, figsize=(9, 7), sharex=True, sharey=True, constrained_layout=True)
    for axes, (name, basin) in zip(panels.flat, BASINS.items()):
        for row in rows:
            if row['name'] == name:
                draw(axes, row)
        finish(axes, '', '')
        axes.set_title(basin.title.replace(', told', '\ntold'), loc='left', fontsize=11)
        axes.set_xlim(0.0, FAR[0])
        axes.set_ylim(0.0, 102.0)
    for axes in panels[1]:
        axes.set_xlabel('guess off by [m], and by 4.5° for each 0.1 m')
    for axes in panels[:, 0]:
        axes.set_ylabel('found [%]')
    lines = [pyplot.Line2D([], [], color=COLORS[matcher], label=NAMES[matcher]) for matcher in MATCHERS]
    lines += [pyplot.Line2D([], [], color='black', label='refined', **ANSWER),
              pyplot.Line2D([], [], color='black', label='search alone', **SEARCH)]
    figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 0.94))
    figure.legend(handles=lines, loc='upper center', ncol=5, frameon=False)
    save(figure, 'figures/basins.png')


if __name__ == '__main__':
    main()
