#!/usr/bin/env python3
"""Runs whole programs over bags and writes a dated report of accuracy, time and memory.

Source the workspace first (`source .workspace/devel/setup.bash`), then:

    benchmark/run_bags.py [--out DIR] [--data DIR] [--runs N] [--matcher NAME]...

Simulated bags are made anew from their seeds. Recordings are taken from --data when they are there.
"""

import argparse
import json
import os
import statistics
import sys
import tempfile

from report_heading import SOURCE, default_folder, heading, run

SIMULATED = [('rooms', 1), ('random', 1), ('loop', 1), ('loop', 2), ('loop', 3)]

# name, map_bag options, truth (None: no truth)
RECORDINGS = [
    ('jarvis_circular', ['--scan-topic', '/driver_laser_security/laser_scan'],
     'jarvis_circular.truth.tum'),
    ('intel', [], None),
    ('guardian', ['--scan-topic', '/scan'], None),
    ('hokuyo_handheld', ['--no-odom'], None),
]


def program(name):
    return ['rosrun', 'matchbox_slam', name]


def simulate(world, seed, folder):
    bag = os.path.join(folder, '%s-%d.bag' % (world, seed))
    truth = os.path.join(folder, '%s-%d.tum' % (world, seed))
    run(program('simulate') + ['--world', world, '--seed', str(seed), '--bag', bag,
                               '--truth', truth])
    return bag, truth


def trajectory_error(estimate, truth):
    """ATE in metres, root mean square after SE(2) alignment."""
    result = json.loads(run(program('evaluate') + ['ate', estimate, '--truth', truth, '--json']))
    return result['estimates'][0]['rmse_m']


def measure(name, bag, options, truth, matcher, runs, folder):
    """One row: the medians over the runs, which all yield the same trajectory."""
    reports = []
    out = os.path.join(folder, name + '-' + matcher)
    for _ in range(runs):
        run(program('map_bag') + [bag, '--out', out, '--matcher', matcher, '--quiet'] + options)
        with open(os.path.join(out, 'report.json')) as file:
            reports.append(json.load(file))
    report = reports[0]

    def median(value):
        return statistics.median(value(r) for r in reports)

    row = {
        'bag': name, 'matcher': matcher, 'scans': report['scans']['received'],
        'used': report['scans']['used'],
        'match_p50': median(lambda r: r['match_ms']['p50']),
        'match_p95': median(lambda r: r['match_ms']['p95']),
        'match_max': median(lambda r: r['match_ms']['max']),
        'scan_ms': median(lambda r: 1e3 * r['cpu_s'] / r['scans']['used']),
        'faster': median(lambda r: r['real_time_factor']),
        'memory': median(lambda r: r['peak_rss_mb']),
        'error': None, 'odometry_error': None,
        'configuration': report['configuration'],
    }
    if truth:
        row['error'] = trajectory_error(os.path.join(out, 'trajectory.tum'), truth)
        row['odometry_error'] = trajectory_error(os.path.join(out, 'odometry.tum'), truth)
    return row


def metres(value):
    return '–' if value is None else '%.4f' % value


def table(rows):
    lines = ['| bag | matcher | scans used | match ms p50 / p95 / max | whole program, CPU ms a scan '
             '| times real time | peak MB | ATE m | raw odometry ATE m |',
             '|---|---|---|---|---|---|---|---|---|']
    for r in rows:
        lines.append('| %s | %s | %d of %d | %.2f / %.2f / %.2f | %.2f | %.0f | %.0f | %s | %s |' % (
            r['bag'], r['matcher'], r['used'], r['scans'], r['match_p50'], r['match_p95'],
            r['match_max'], r['scan_ms'], r['faster'], r['memory'], metres(r['error']),
            metres(r['odometry_error'])))
    return '\n'.join(lines)


def write_report(rows, arguments, folder):
    os.makedirs(folder, exist_ok=True)
    text = '\n'.join(heading('Whole programs over bags', 'run_bags.py', arguments) + [
        '- each figure of time and memory is the median of the runs; the seed of `map_bag` is 1, that '
        'of a simulated bag stands behind its name; ATE is the root mean square after SE(2) alignment',
        '- the effective configuration of each matcher lies beside this page', '',
        table(rows), ''])
    with open(os.path.join(folder, 'REPORT.md'), 'w') as file:
        file.write(text)
    for row in rows:
        with open(os.path.join(folder, row['matcher'] + '.json'), 'w') as file:
            shared = {k: v for k, v in row['configuration'].items() if not k.endswith('_frame')}
            json.dump(shared, file, indent=2, sort_keys=True)
            file.write('\n')
    print(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--out', default=default_folder())
    parser.add_argument('--data', default=os.environ.get(
        'MATCHBOX_DATA', os.path.join(SOURCE, '..', 'shared', 'data')))
    parser.add_argument('--runs', type=int, default=3)
    parser.add_argument('--matcher', action='append')
    arguments = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        bags = [('%s-%d' % (world, seed), [], simulate(world, seed, folder))
                for world, seed in SIMULATED]
        for name, options, truth in RECORDINGS:
            bag = os.path.join(arguments.data, name + '.bag')
            if os.path.exists(bag):
                bags.append((name, options,
                             (bag, os.path.join(arguments.data, truth) if truth else None)))
            else:
                print('%s is left out: %s is not there' % (name, bag), file=sys.stderr)
        for matcher in arguments.matcher or ['monte_carlo']:
            for name, options, (bag, truth) in bags:
                rows.append(measure(name, bag, options, truth, matcher, arguments.runs, folder))
    write_report(rows, sys.argv[1:], arguments.out)


if __name__ == '__main__':
    main()
