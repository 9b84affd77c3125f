#!/usr/bin/env python3
"""Runs whole programs over bags and writes a report of accuracy, time and memory.

Source the workspace first (`source .workspace/devel/setup.bash`), then:

    benchmark/run_bags.py [--out DIR] [--data DIR] [--runs N] [--matcher NAME]...
                          [--without WORLD]... [--other RECORDING:SYSTEM=FILE.tum]...

Simulated bags are made anew from their seeds. Recordings are taken from --data when they are there. The
trajectory that another system made of a recording is put beside ours with --other, such as
intel:gmapping=gmapping.tum.
"""

import argparse
import json
import os
import statistics
import sys
import tempfile

from report import SOURCE, default_folder, heading, program, run, simulate

# World, seed, options of simulate
SIMULATED = [('rooms', 1, []), ('random', 1, []), ('loop', 1, []), ('loop', 2, []), ('loop', 3, []),
             ('corridor', 1, []), ('hotel', 1, ['--beams', '360', '--scan-rate', '5']),
             ('campus', 1, ['--beams', '360', '--scan-rate', '5'])]


def corrected(name):
    """By the poses that came with a log."""
    return ['ate', '--truth', name + '.corrected.tum']


# name, bag, map_bag options, what `evaluate` compares with: a metric and its options; files are in --data
RECORDINGS = [
    ('jarvis_circular', 'jarvis_circular', ['--scan-topic', '/driver_laser_security/laser_scan'],
     ['ate', '--truth', 'jarvis_circular.truth.tum']),
    ('jarvis_circular, other laser, no odometry', 'jarvis_circular',
     ['--scan-topic', '/driver_laser_navigation/laser_scan', '--no-odom', '--set', 'scan_time_offset=-0.12'],
     ['ate', '--truth', 'jarvis_circular.truth.tum']),
    ('intel', 'intel', [], ['relations', '--relations', 'intel.relations', '--odometry', 'intel.odom.tum']),
    ('aces', 'aces', [], corrected('aces')),
    ('belgioioso', 'belgioioso', [], corrected('belgioioso')),
    ('infinite_corridor', 'infinite_corridor', [], corrected('infinite_corridor')),
    ('seattle', 'seattle', [], corrected('seattle')),
    ('csail', 'csail', [], corrected('csail')),
    ('acapulco', 'acapulco', [], corrected('acapulco')),
    ('office_narrow90', 'office_narrow90', [], ['ate', '--truth', 'office_narrow90.tum']),
    ('office_lds01_as_sent', 'office_lds01_as_sent', [], ['ate', '--truth', 'office_lds01_as_sent.tum']),
    ('guardian', 'guardian', ['--scan-topic', '/scan'], None),
    ('hokuyo_handheld', 'hokuyo_handheld', ['--no-odom'], None),
    ('inverted_laser', 'inverted_laser', [], None),
]


def error_of(estimate, truth):
    """Metres: root mean square after SE(2) alignment, or mean error of relations."""
    metric, *options = truth
    result = json.loads(run(program('evaluate') + [metric, estimate, '--json'] + options))
    estimate = result['estimates'][0]
    return estimate['rmse_m'] if metric == 'ate' else estimate['translation_m']['mean']


def measure(name, bag, options, truth, matcher, runs, folder):
    """One row: the medians over the runs, which all yield the same trajectory."""
    reports = []
    out = os.path.join(folder, 'out')
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
        'cpu_s': median(lambda r: r['cpu_s']),
        'error': None, 'odometry_error': None,
        'metric': truth[0] if truth else None,
        'configuration': report['configuration'],
    }
    if truth:
        row['error'] = error_of(os.path.join(out, 'trajectory.tum'), truth)
        # Relations hold stamps between the scans, so there the raw odometry is given at full rate.
        odometry = truth[truth.index('--odometry') + 1] if '--odometry' in truth else \
            os.path.join(out, 'odometry.tum')
        if os.path.getsize(odometry):
            row['odometry_error'] = error_of(odometry, truth)
    return row


def measure_other(recording, system, path, bags):
    """What another system made of a recording, by the same metric."""
    for name, _, _, truth in bags:
        if name == recording and truth:
            return {'bag': name, 'matcher': system, 'error': error_of(path, truth),
                    'metric': truth[0]}
    sys.exit('run_bags.py: --other %s: there is no truth of that recording; allowed: %s' % (
        recording, ', '.join(name for name, _, _, truth in bags if truth)))


def metres(value):
    return '–' if value is None else '%.4f' % value


def table(rows):
    lines = ['| bag | matcher | scans used | match ms p50 / p95 / max | whole program, CPU ms a scan '
             '| times real time | peak MB | error m | raw odometry, error m |',
             '|---|---|---|---|---|---|---|---|---|']
    for r in rows:
        lines.append('| %s | %s | %d of %d | %.2f / %.2f / %.2f | %.2f | %.0f | %.0f | %s | %s |' % (
            r['bag'], r['matcher'], r['used'], r['scans'], r['match_p50'], r['match_p95'],
            r['match_max'], r['scan_ms'], r['faster'], r['memory'], metres(r['error']),
            metres(r['odometry_error'])))
    return '\n'.join(lines)


def short_table(rows):
    """Errors and times of the matchers side by side."""
    matchers = list(dict.fromkeys(row['matcher'] for row in rows))
    cells = {(row['bag'], row['matcher']): row for row in rows}
    lines = [' | '.join(['| bag', 'odometry alone, m'] + ['%s, m' % name for name in matchers] +
                        ['%s, CPU s' % name for name in matchers]) + ' |',
             '|---' * (2 + 2 * len(matchers)) + '|']
    for bag in dict.fromkeys(row['bag'] for row in rows):
        own = [cells[(bag, name)] for name in matchers]
        lines.append(' | '.join(['| ' + bag, metres(own[0]['odometry_error'])] +
                                [metres(row['error']) for row in own] +
                                ['%.2f' % row['cpu_s'] for row in own]) + ' |')
    return '\n'.join(lines)


def other_table(rows, others):
    """Other systems, and ours on the same recordings."""
    if not others:
        return ''
    recordings = {other['bag'] for other in others}
    lines = ['', '| recording | system | error m |', '|---|---|---|']
    for row in others + [row for row in rows if row['bag'] in recordings]:
        lines.append('| %s | %s | %s |' % (row['bag'], row['matcher'], metres(row['error'])))
    return '\n'.join(lines)


def shared_configurations(rows):
    """By matcher, the effective configuration it had on every bag, without what differs between them."""
    shared = {}
    for row in rows:
        own = row['configuration']
        before = shared.get(row['matcher'], own)
        shared[row['matcher']] = {key: value for key, value in before.items()
                                  if key in own and own[key] == value}
    return shared


def write_report(rows, others, arguments, folder):
    os.makedirs(folder, exist_ok=True)
    text = '\n'.join(heading('Whole programs over bags', 'run_bags.py', arguments) + [
        '- each figure of time and memory is the median of the runs; the seed of `map_bag` is 1, that '
        'of a simulated bag stands behind its name',
        '- error: root mean square distance from the truth after SE(2) alignment (ATE); of intel the mean '
        'error of its verified relations',
        '- the effective configuration of each matcher lies beside this page, without what differs '
        'between the bags', '', short_table(rows), '',
        table(rows), other_table(rows, others), ''])
    with open(os.path.join(folder, 'BAGS.md'), 'w') as file:
        file.write(text)
    for matcher, configuration in shared_configurations(rows).items():
        with open(os.path.join(folder, matcher + '.json'), 'w') as file:
            json.dump(configuration, file, indent=2, sort_keys=True)
            file.write('\n')
    print(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--out', default=default_folder())
    parser.add_argument('--data', default=os.environ.get(
        'MATCHBOX_DATA', os.path.join(SOURCE, '..', 'shared', 'data')))
    parser.add_argument('--runs', type=int, default=3)
    parser.add_argument('--without', metavar='WORLD', action='append', default=[], help='a simulated world to leave out')
    parser.add_argument('--matcher', action='append')
    parser.add_argument('--other', action='append', default=[],
                        metavar='RECORDING:SYSTEM=FILE.tum')
    arguments = parser.parse_args()
    if arguments.runs < 1:
        parser.error('--runs: %d is not allowed; allowed: at least 1' % arguments.runs)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        bags = []
        for world, seed, options in SIMULATED:
            if world in arguments.without:
                continue
            bag, truth = simulate(world, seed, folder, *options)
            bags.append(('%s-%d' % (world, seed), bag, [], ['ate', '--truth', truth]))
        for name, recording, options, truth in RECORDINGS:
            bag = os.path.join(arguments.data, recording + '.bag')
            if os.path.exists(bag):
                bags.append((name, bag, options, truth and [
                    os.path.join(arguments.data, word) if '.' in word else word
                    for word in truth]))
            else:
                print('%s is left out: %s is not there' % (name, bag), file=sys.stderr)
        others = []
        for other in arguments.other:
            if ':' not in other or '=' not in other:
                parser.error('--other: %r is not RECORDING:SYSTEM=FILE.tum' % other)
            recording, rest = other.split(':', 1)
            others.append(measure_other(recording, *rest.split('=', 1), bags))
        for matcher in arguments.matcher or ['olson', 'hough', 'monte_carlo']:
            for name, bag, options, truth in bags:
                rows.append(measure(name, bag, options, truth, matcher, arguments.runs, folder))
    write_report(rows, others, sys.argv[1:], arguments.out)


if __name__ == '__main__':
    main()
