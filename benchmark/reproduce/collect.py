#!/usr/bin/env python3
"""Puts the results of all jobs together, in the folder of the run: summary.json has what is the same on any
machine and any number of cores, times.json the rest."""

import argparse
import datetime
import json
import os
import platform

import verdicts
from experiments import BASELINE, COMPLEXITIES, MATCHERS, NOISES, SIZES, TESTS, complexity_points
from exponents import fit
from files import read_json, write_json
from pair_errors import median_errors_mm

ALL = list(MATCHERS) + [BASELINE]


def pair_row(test, noise, matcher):
    """One row of tables II to V, with its time, and the configuration it was measured with."""
    folder = os.path.join('pairs', test, noise, matcher)
    summary = read_json(os.path.join(folder, 'summary.json'))
    result = summary['matchers'][0]
    x, y = median_errors_mm(os.path.join(folder, 'pairs.csv'),
                            os.path.join('bags', '%s-%s.tum' % (TESTS[test].world, noise)))
    row = {'test': test, 'noise': noise, 'matcher': matcher, 'pairs': result['pairs'],
           'success_rate': result['success_rate'], 'median_x_mm': x, 'median_y_mm': y,
           'time_ms': result['time_ms']}
    for errors in ('translation_mm', 'heading_mrad'):
        row[errors] = {key: result[errors][key] for key in ('median', 'p95', 'max')}
    return row, result['configuration'], summary['version']


def map_row(matcher, seed, has_truth):
    """Quality and error of one of the maps of figure 6, and its times."""
    folder = os.path.join('maps', 'recording', matcher, 'given', str(seed))
    report = read_json(os.path.join(folder, 'report.json'))
    quality = read_json(os.path.join(folder, 'quality.json'))['maps'][0]
    row = {'matcher': matcher, 'scans': report['scans']['received'], 'used': report['scans']['used'],
           'quality': {key: quality[key] for key in (
               'occupied_of_known', 'corners', 'enclosed_areas', 'known_cells', 'resolution_m')}}
    if has_truth and matcher != BASELINE:
        errors = read_json(os.path.join(folder, 'ate.json'))['estimates']
        for name, error in zip(('trajectory', 'odometry'), errors):
            row[name] = {key: error[key] for key in ('rmse_m', 'median_m', 'max_m', 'heading_rmse_rad')}
    times = {'matcher': matcher, 'match_ms': report['match_ms'], 'wall_s': report['wall_s'],
             'cpu_s': report['cpu_s'], 'real_time_factor': report['real_time_factor']}
    return row, times


def complexity_row(name, size):
    complexity = COMPLEXITIES[name]
    points = complexity_points(name, size)
    times = [read_json(os.path.join('complexity', name, str(x), 'summary.json'))['matchers'][0]['time_ms']
             for x, _, _ in points]
    x, medians = [point[0] for point in points], [time['median'] for time in times]
    return {'name': name, 'matcher': complexity.matcher, 'quantity': complexity.quantity,
            'unit': complexity.unit,
            'paper': complexity.paper, 'how': complexity.how, 'x': x, 'time_ms': medians,
            'settings': [options for _, _, options in points], 'fit': fit(x, medians)}


def machine():
    model = platform.machine()
    with open('/proc/cpuinfo') as file:
        for line in file:
            if line.startswith('model name'):
                model = line.split(':', 1)[1].strip()
                break
    return '%s, %d cores, %s' % (model, os.cpu_count(), platform.platform())


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--options', required=True, help='JSON')
    parser.add_argument('--commit', required=True)
    parser.add_argument('--programs', required=True, help='fingerprint')
    arguments = parser.parse_args()
    options = json.loads(arguments.options)
    size = SIZES[options['size']]
    cells = [pair_row(test, noise, matcher)
             for test in TESTS for noise in NOISES for matcher in ALL]
    rows = [row for row, _, _ in cells]
    configurations = {row['matcher']: configuration for row, configuration, _ in cells}
    slow = [miss for row in rows for miss in verdicts.time_misses(row)]
    times = [{'test': row['test'], 'noise': row['noise'], 'matcher': row['matcher'],
              'time_ms': row.pop('time_ms')} for row in rows]
    maps = [map_row(matcher, options['seed'], options['has_truth']) for matcher in ALL]
    write_json('summary.json', {
        'options': options, 'commit': arguments.commit or None, 'programs': arguments.programs,
        'version': cells[0][2], 'tests': rows, 'maps': [row for row, _ in maps],
        'configurations': configurations,
        'missed': [miss for row in rows for miss in verdicts.accuracy_misses(row)]})
    write_json('times.json', {
        'date': datetime.date.today().isoformat(), 'machine': machine(), 'tests': times, 'missed': slow,
        'maps': [row for _, row in maps],
        'complexity': [complexity_row(name, size) for name in COMPLEXITIES]})


if __name__ == '__main__':
    main()
