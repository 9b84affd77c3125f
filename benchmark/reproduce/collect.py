#!/usr/bin/env python3
"""Puts the results of all jobs together, in the folder of the run: summary.json has what is the same on any
machine and any number of cores, times.json the rest. A job that failed is a row that says why."""

import argparse
import csv
import glob
import json
import os
import re

import verdicts
from experiments import (BASELINE, BASIN_BINS, BASINS, BUDGETS, COMPLEXITIES, FAR, FOUND, HARD, MATCHERS, NAMES, NOISES,
                         SEARCHES, TESTS, bag_together)
from exponents import fit
from files import Failed, log_lines, write_json
from pair_errors import found_by_guess, found_shares, median, median_errors_mm, read_pairs
from results import Made, result_of_map, result_of_pairs

ALL = list(MATCHERS) + [BASELINE]


def pair_row(test, noise, matcher, seed, made):
    """One row of tables II to V with its time, and all that match_pairs tells."""
    row = {'test': test, 'noise': noise, 'matcher': matcher}
    folder = os.path.join('pairs', test, noise, matcher)
    try:
        summary, result = result_of_pairs(folder, matcher, seed)
    except Failed as failure:
        return dict(row, failed=str(failure)), None
    made.add(summary)
    x, y = median_errors_mm(os.path.join(folder, 'pairs.csv'),
                            os.path.join('bags', '%s-%s.tum' % (TESTS[test].world, noise)))
    row.update(pairs=result['pairs'], success_rate=result['success_rate'], median_x_mm=x, median_y_mm=y,
               time_ms=result['time_ms'])
    for errors in ('translation_mm', 'heading_mrad'):
        row[errors] = {key: result[errors][key] for key in ('median', 'p95', 'max')}
    search = result['search']
    row['search'] = {'success_rate': search['success_rate'], 'mm': search['translation_mm']['median'],
                     'mrad': search['heading_mrad']['median']}
    return row, summary


def together_row(kind, name, matcher, seed, made, told):
    """What `told` makes of the errors of one matcher's pairs, and the time of a match, of a job in which all
    matchers matched the same pairs."""
    row, folder = {'name': name, 'matcher': matcher}, os.path.join(kind, name)
    try:
        summary, result = result_of_pairs(folder, matcher, seed)
    except Failed as failure:
        return dict(row, failed=str(failure)), dict(row, failed=str(failure))
    made.add(summary)
    truth = os.path.join('bags', bag_together(kind, name) + '.tum')
    pairs = read_pairs(os.path.join(folder, 'pairs.csv'), truth, matcher)
    return (dict(row, pairs=result['pairs'], beams=summary['beams'], **told(pairs)),
            dict(row, time_ms=result['time_ms'], success_rate=result['success_rate']))


def basin_figures(pairs):
    return {'found': found_by_guess(pairs, FOUND, FAR[0], BASIN_BINS)}


def hard_figures(pairs):
    return {'found': found_shares(pairs, FOUND), 'search_mm_mrad': median(pairs, 'search'),
            'answer_mm_mrad': median(pairs, 'answer')}


def together_rows(kind, names, seed, made, told):
    """Those of a kind: the results, and the times."""
    rows = [together_row(kind, name, matcher, seed, made, told) for name in names for matcher in MATCHERS]
    return [row for row, _ in rows], [times for _, times in rows]


def map_row(matcher, seed, has_truth, made):
    """Quality and error of one of the maps of figure 6, its times, and its configuration."""
    folder = os.path.join('maps', 'recording', matcher, 'given', str(seed))
    try:
        report, quality, errors = result_of_map(folder, matcher, seed, has_truth and matcher != BASELINE)
    except Failed as failure:
        row = {'matcher': matcher, 'failed': str(failure)}
        return row, dict(row), {}
    made.add(report)
    row = {'matcher': matcher, 'scans': report['scans']['received'], 'used': report['scans']['used'],
           'quality': {key: quality[key] for key in (
               'occupied_of_known', 'corners', 'enclosed_areas', 'known_cells', 'resolution_m')}}
    for name, error in zip(('trajectory', 'odometry'), errors):
        row[name] = {key: error[key] for key in ('rmse_m', 'median_m', 'max_m', 'heading_rmse_rad')}
    times = {'matcher': matcher, 'match_ms': report['match_ms'], 'wall_s': report['wall_s'],
             'cpu_s': report['cpu_s'],
             'scan_ms': 1000.0 * report['cpu_s'] / report['scans']['used']}
    return row, times, report['configuration']


def milliseconds(path):
    with open(path) as file:
        return [1e-3 * float(row['time_us']) for row in csv.DictReader(file)]


def complexity_row(name, seed, made):
    complexity = COMPLEXITIES[name]
    row = {'name': name, 'matcher': complexity.matcher, 'quantity': complexity.quantity,
           'unit': complexity.unit, 'paper': complexity.paper, 'how': complexity.how,
           'settings': [options for _, _, options in complexity.points]}
    x, samples = [], []
    try:
        for point, _, _ in complexity.points:
            folder = os.path.join('complexity', name, str(point))
            summary, result = result_of_pairs(folder, complexity.matcher, seed)
            made.add(summary)
            # Cells for each metre, and metres; the rest is in the paper's own unit.
            x.append(round(point * summary['reach_m']) if name == 'hough-domain' else point)
            samples.append(milliseconds(os.path.join(folder, 'pairs.csv')))
            row.setdefault('time_ms', []).append(result['time_ms']['median'])
    except Failed as failure:
        return dict(row, failed=str(failure))
    return dict(row, x=x, pairs=len(samples[0]), fit=fit(x, samples))


def budget_row(name, seed, made):
    try:
        summary, result = result_of_pairs(os.path.join('budgets', name), BUDGETS[name].matcher, seed)
    except Failed as failure:
        return {'name': name, 'failed': str(failure)}
    made.add(summary)
    return {'name': name, 'time_ms': result['time_ms'], 'success_rate': result['success_rate'],
            'pairs': result['pairs']}


def commands():
    """Of all jobs that are there, as they were run, without the programs' folders."""
    logs = sorted(path for pattern in ('pairs/*/*/*', 'budgets/*', 'complexity/*/*', 'searches/*', 'basins/*', 'hard/*',
                                       'maps/recording/*/given/*') for path in glob.glob(pattern + '/*.log'))
    return [re.sub(r'^\S*/', '', line) for log in logs for line in log_lines(log)[0]]


def differences(configurations, others):
    """Of the maps' configurations to those of the tests: {matcher: {key: value}}."""
    return {matcher: {key: value for key, value in others[matcher].items()
                      if configurations.get(matcher, {}).get(key) != value}
            for matcher in others if others[matcher]}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--options', required=True, help='JSON')
    parser.add_argument('--programs', required=True, help='JSON: fingerprints')
    arguments = parser.parse_args()
    options = json.loads(arguments.options)
    seed, made = options['seed'], Made()
    cells = [pair_row(test, noise, matcher, seed, made)
             for test in TESTS for noise in NOISES for matcher in ALL]
    rows = [row for row, _ in cells]
    told = [(row['matcher'], summary) for row, summary in cells if summary]
    configurations = {matcher: summary['matchers'][0]['configuration'] for matcher, summary in told}
    maps = [map_row(matcher, seed, options['has_truth'], made) for matcher in ALL]
    complexity = [complexity_row(name, seed, made) for name in COMPLEXITIES]
    budgets = [budget_row(name, seed, made) for name in BUDGETS]
    _, searches = together_rows('searches', SEARCHES, seed, made, hard_figures)
    basins, basin_times = together_rows('basins', BASINS, seed, made, basin_figures)
    hard, hard_times = together_rows('hard', HARD, seed, made, hard_figures)
    slow = ([miss for row in rows for miss in verdicts.time_misses(row)] +
            [miss for row in budgets for miss in verdicts.budget_misses(row)] +
            [miss for _, row, _ in maps for miss in verdicts.scan_misses(row)])
    times = [{key: row[key] for key in ('test', 'noise', 'matcher', 'time_ms', 'failed') if key in row}
             for row in rows]
    failed = (verdicts.failures(rows, verdicts.name_of) +
              verdicts.failures([row for row, _, _ in maps], lambda row: 'the map by ' + NAMES[row['matcher']]) +
              verdicts.failures(budgets, lambda row: BUDGETS[row['name']].title) +
              verdicts.failures(complexity, lambda row: 'table I, ' + row['name']) +
              verdicts.failures(searches + basins + hard, lambda row: '%s, %s' % (NAMES[row['matcher']], row['name'])))
    for row in rows:
        row.pop('time_ms', None)
    write_json('summary.json', {
        'options': options, 'commit': ', '.join(sorted(made.commits)), 'version': ', '.join(sorted(made.versions)),
        'about': {key: told[0][1][key] for key in ('beams', 'gap_s', 'success_xy_m', 'success_theta_rad')}
                 if told else {},
        'tests': rows, 'basins': basins, 'hard': hard, 'maps': [row for row, _, _ in maps],
        'configurations': configurations,
        'map_configurations': differences(configurations, {row['matcher']: own for row, _, own in maps}),
        'missed': [miss for row in rows for miss in verdicts.accuracy_misses(row)], 'failed': failed})
    write_json('times.json', {
        'machines': made.places(), 'programs': json.loads(arguments.programs), 'tests': times, 'missed': slow,
        'maps': [row for _, row, _ in maps], 'complexity': complexity, 'budgets': budgets,
        'searches': searches, 'basins': basin_times, 'hard': hard_times, 'commands': commands()})


if __name__ == '__main__':
    main()
