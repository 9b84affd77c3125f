#!/usr/bin/env python3
"""Measures how the cost of a scan grows with beams, window, map and cells, and writes a report.

    benchmark/run_scaling.py [--out DIR] [--build DIR | --program PATH] [--repetitions N]

Needs Google Benchmark, as run_micro.py. Without --build or --program, which names the program `benchmarks`
of a workspace, everything is built in a temporary folder.
"""

import argparse
import os
import sys
import tempfile

from report import default_folder, heading
from run_micro import SECONDS_OF, build, measure

TITLES = {
    'beams': 'Beams',
    'window': 'Window of the search, m to each side, with a prior as wide',
    'map': 'Length of the map, m',
    'cells': 'Edge of a cell, cm',
}
PARTS = {'project': 'projection', 'match': 'match of `olson`', 'insert': 'insertion into the map'}


def least(results):
    """By subject, value and part: the least time of all repetitions [s]."""
    times = {}
    for result in results:
        if result.get('error_occurred'):
            sys.exit('run_scaling.py: %s: %s' % (result['name'], result['error_message']))
        if result.get('run_type') == 'aggregate':
            continue
        name, value = result['run_name'].split('/')
        _, subject, part = name.split('_')
        number = float(value.split(':')[1])
        value = number / 100.0 if subject == 'window' else number
        seconds = result['cpu_time'] * SECONDS_OF[result['time_unit']]
        parts = times.setdefault(subject, {}).setdefault(value, {})
        parts[part] = min(seconds, parts.get(part, seconds))
    return times


def table(subject, by_value):
    parts = [part for part in PARTS if any(part in row for row in by_value.values())]
    lines = ['| %s | %s |' % (TITLES[subject], ' | '.join('%s, µs' % PARTS[p] for p in parts)),
             '| --- |' + ' --- |' * len(parts)]
    for value, row in sorted(by_value.items()):
        lines.append('| %g | %s |' % (value, ' | '.join('%.0f' % (1e6 * row[p]) for p in parts)))
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--out', default=default_folder())
    parser.add_argument('--build', help='folder to build in and to keep')
    parser.add_argument('--program', help='benchmarks that are built already')
    parser.add_argument('--repetitions', type=int, default=3)
    arguments = parser.parse_args()
    os.makedirs(arguments.out, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        program = arguments.program or build(arguments.build or folder)
        times = least(measure(program, folder, arguments.repetitions, '^scaling_'))
    lines = heading('How the cost of a scan grows', 'run_scaling.py', sys.argv[1:]) + [
        '- CPU time on one core, the least of %d repetitions; simulated rooms, 1040 beams, cells of '
        '5 cm and a window of 3 sigmas of 5 cm and 0.03 rad unless the table says otherwise'
        % arguments.repetitions,
        '- a long map is that of the rooms, again and again along a line', '']
    for subject in TITLES:
        lines += table(subject, times[subject]) + ['']
    path = os.path.join(arguments.out, 'SCALING.md')
    with open(path, 'w') as file:
        file.write('\n'.join(lines))
    print(path)


if __name__ == '__main__':
    main()
