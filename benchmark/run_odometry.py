#!/usr/bin/env python3
"""Runs laser odometry with every matcher over bags and writes a report of its drift.

Build what it runs (`ninja -C .workspace/build scan_odometry_bag`, besides the package), source the workspace, then:

    benchmark/run_odometry.py [--out DIR] [--data DIR] [--matcher NAME]...

Simulated bags are made anew from their seeds. Recordings are taken from --data when they are there.
"""

import argparse
import json
import os
import sys
import tempfile

from report import SOURCE, default_folder, heading, program, run, simulate

SIMULATED = [('rooms', 1), ('random', 1), ('loop', 1)]

SECURITY_LASER = ['--scan-topic', '/driver_laser_security/laser_scan']
NAVIGATION_LASER = ['--scan-topic', '/driver_laser_navigation/laser_scan']  # above most furniture
# Its scans are stamped about as late as a sweep of 125 ms takes, by its trajectory and the truth.
CORRECTED = ['--set', 'scan_time_offset=-0.12']

# Those with truth along the way: name in the report, bag, options, truth
RECORDINGS = [
    ('jarvis_circular security', 'jarvis_circular.bag', SECURITY_LASER,
     'jarvis_circular.truth.tum'),
    ('jarvis_circular navigation', 'jarvis_circular.bag', NAVIGATION_LASER,
     'jarvis_circular.truth.tum'),
    ('jarvis_circular navigation, stamps corrected', 'jarvis_circular.bag',
     NAVIGATION_LASER + CORRECTED, 'jarvis_circular.truth.tum'),
]
INTEL = ['--relations', 'intel.relations', '--odometry', 'intel.odom.tum']
AT_REST = 'inverted_laser'

GUESSES = ['velocity', 'odometry']


def drift_of(estimate, truth):
    """Root mean square over pairs: metres per metre, radians per radian and per metre."""
    result = json.loads(run(program('evaluate') + ['rpe', estimate, '--truth', truth, '--json']))
    measures = result['estimates'][0]['measures']

    def rmse(measure, unit):
        return measures[measure][unit]['rmse'] if measures[measure] else None

    return {'per_metre': rmse('per_1_m', 'translation_m'),
            'per_ten_metres': rmse('per_10_m', 'translation_m'),
            'turn_per_metre': rmse('per_1_m', 'rotation_rad'),
            'turn_per_radian': rmse('per_1_rad', 'rotation_rad')}


def measure(name, bag, options, matcher, guess, folder):
    """Runs over a bag; the estimate and the report of the run."""
    out = os.path.join(folder, '-'.join([os.path.basename(name), matcher, guess]))
    run(program('scan_odometry_bag') + [
        bag, '--out', out, '--config', os.path.join(SOURCE, 'config', matcher + '.yaml'),
        '--set', 'guess=' + guess] + options)
    with open(os.path.join(out, 'report.json')) as file:
        return out, json.load(file)


def cells(drift):
    def text(value, scale, digits):
        return '–' if value is None else '%.*f' % (digits, scale * value)
    return [text(drift['per_metre'], 1e3, 1), text(drift['per_ten_metres'], 1e3, 1),
            text(drift['turn_per_metre'], 1e3, 2), text(drift['turn_per_radian'], 1e3, 2)]


def row(*columns):
    return '| ' + ' | '.join(str(column) for column in columns) + ' |'


def drift_table(bags, matchers, folder):
    lines = [row('recording', 'odometry', 'guess', 'scans', 'matched', 'restarts',
                 'mm per 1 m', 'mm per 10 m', 'mrad per 1 m', 'mrad per 1 rad',
                 'ms a scan, p50 / p95', 'local maps MB'),
             row(*['---'] * 12)]
    for name, bag, options, truth in bags:
        for matcher in matchers:
            for guess in GUESSES:
                out, report = measure(name, bag, options, matcher, guess, folder)
                matched = report['matches'].get('accepted', 0)
                lines.append(row(
                    name, matcher, guess, '%d of %d' % (report['scans']['used'],
                                                        report['scans']['received']),
                    matched, report['restarts'],
                    *cells(drift_of(os.path.join(out, 'scan_odometry.tum'), truth)),
                    '%.2f / %.2f' % (report['scan_ms']['p50'], report['scan_ms']['p95']),
                    '%.1f' % report['local_maps_mb']))
        lines.append(row(name, 'wheels', '–', report['scans']['used'], '–', '–',
                         *cells(drift_of(os.path.join(out, 'odometry.tum'), truth)), '–', '–'))
    return lines


def relations_of(estimate, data):
    result = json.loads(run(program('evaluate') + ['relations', estimate, '--json'] + [
        os.path.join(data, word) if '.' in word else word for word in INTEL]))['estimates'][0]
    return ['%.3f' % result['translation_m']['mean'], '%.4f' % result['rotation_rad']['mean']]


def intel_table(data, matchers, folder):
    """Scans half a metre and 18 degrees apart: only with the wheels' guess."""
    lines = [row('odometry', 'scans', 'matched', 'restarts', 'm a relation', 'rad a relation'),
             row(*['---'] * 6)]
    for matcher in matchers:
        out, report = measure('intel', os.path.join(data, 'intel.bag'), [], matcher, 'odometry',
                              folder)
        lines.append(row(matcher, report['scans']['used'], report['matches'].get('accepted', 0),
                         report['restarts'],
                         *relations_of(os.path.join(out, 'scan_odometry.tum'), data)))
    lines.append(row('wheels', report['scans']['used'], '–', '–',
                     *relations_of(os.path.join(data, 'intel.odom.tum'), data)))
    return lines


def rest_table(data, matchers, folder):
    lines = [row('odometry', 'scans', 'farthest from the start mm', 'mrad'), row(*['---'] * 4)]
    for matcher in matchers:
        out, report = measure(AT_REST, os.path.join(data, AT_REST + '.bag'), [], matcher,
                              'velocity', folder)
        with open(os.path.join(out, 'scan_odometry.tum')) as file:
            poses = [[float(word) for word in line.split()] for line in file]
        lines.append(row(matcher, report['scans']['used'],
                         '%.1f' % (1e3 * max((p[1] ** 2 + p[2] ** 2) ** 0.5 for p in poses)),
                         '%.2f' % (1e3 * max(2.0 * abs(p[6]) for p in poses))))
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--out', default=default_folder())
    parser.add_argument('--data', default=os.environ.get(
        'MATCHBOX_DATA', os.path.join(SOURCE, '..', 'shared', 'data')))
    parser.add_argument('--matcher', action='append')
    arguments = parser.parse_args()
    matchers = arguments.matcher or ['olson', 'hough', 'monte_carlo']

    def in_data(name):
        path = os.path.join(arguments.data, name)
        if not os.path.exists(path):
            print('%s is left out: it is not there' % path, file=sys.stderr)
        return os.path.exists(path)

    lines = heading('Laser odometry without a map', 'run_odometry.py', sys.argv[1:]) + [
        '- drift: relative pose error of `evaluate rpe`, root mean square over pairs of poses 1 m or 10 m '
        'of the true path, or 1 rad of true turning, apart',
        '- guess: where each match starts, `velocity` (the last motion goes on) or `odometry` (of the '
        "wheels); 'wheels' is the raw odometry of the recording at the same stamps",
        '- stamps corrected: those of the navigation laser are about a sweep late; with '
        '`scan_time_offset=-0.12` its heading agrees with the truth',
        '- seed 1, configuration of `config/MATCHER.yaml`; times are those that a scan had on a processor', '']
    with tempfile.TemporaryDirectory() as folder:
        bags = []
        for world, seed in SIMULATED:
            bag, truth = simulate(world, seed, folder)
            bags.append(('%s-%d' % (world, seed), bag, [], truth))
        for name, bag, options, truth in RECORDINGS:
            if in_data(bag) and in_data(truth):
                bags.append((name, os.path.join(arguments.data, bag), options,
                             os.path.join(arguments.data, truth)))
        lines += drift_table(bags, matchers, folder)
        if in_data('intel.bag'):
            lines += ['', 'intel, mean error of its verified relations, scans half a metre and 18° '
                      'apart:', ''] + intel_table(arguments.data, matchers, folder)
        if in_data(AT_REST + '.bag'):
            lines += ['', AT_REST + ', a robot at rest:', ''] + rest_table(
                arguments.data, matchers, folder)
    os.makedirs(arguments.out, exist_ok=True)
    with open(os.path.join(arguments.out, 'ODOMETRY.md'), 'w') as file:
        file.write('\n'.join(lines) + '\n')
    print('\n'.join(lines))


if __name__ == '__main__':
    main()
