#!/usr/bin/env python3
"""Builds the micro-benchmarks without ROS, runs them and writes a report of their times.

    benchmark/run_micro.py [--out DIR] [--build DIR] [--repetitions N] [--filter REGEX]

Needs Google Benchmark (libbenchmark-dev) besides what the package needs. Without --build everything is
built in a temporary folder.
"""

import argparse
import json
import os
import sys
import tempfile

from report import SOURCE, default_folder, heading, run

SECONDS_OF = {'ns': 1e-9, 'us': 1e-6, 'ms': 1e-3, 's': 1.0}


def build(folder):
    """The path of the program, built for speed."""
    run(['cmake', '-S', SOURCE, '-B', folder, '-DMATCHBOX_WITH_ROS=OFF', '-DBUILD_TESTING=OFF',
         '-DMATCHBOX_SANITIZE=', '-DCMAKE_BUILD_TYPE=Release'])
    if 'benchmark_DIR:PATH=benchmark_DIR-NOTFOUND' in run(['cmake', '-L', '-A', '-N', folder]):
        sys.exit('run_micro.py: Google Benchmark is missing; on Debian and Ubuntu install '
                 'libbenchmark-dev')
    run(['cmake', '--build', folder, '--target', 'benchmarks', '-j', str(os.cpu_count())])
    return os.path.join(folder, 'benchmark', 'micro', 'benchmarks')


def measure(program, folder, repetitions, name_filter):
    """The results of all repetitions as Google Benchmark writes them."""
    path = os.path.join(folder, 'micro.json')
    run([program, '--benchmark_repetitions=%d' % repetitions, '--benchmark_filter=' + name_filter,
         '--benchmark_enable_random_interleaving=true', '--benchmark_out=' + path,
         '--benchmark_out_format=json'])
    with open(path) as file:
        return json.load(file)['benchmarks']


def time_text(seconds):
    for unit, length in (('s', 1.0), ('ms', 1e-3), ('µs', 1e-6)):
        if seconds >= length:
            return '%.3g %s' % (seconds / length, unit)
    return '%.3g ns' % (seconds / 1e-9)


def rate_text(items_per_second):
    return '–' if items_per_second is None else '%.3g million' % (items_per_second / 1e6)


def medians(results):
    """By subject, in the order of the program: parameter and what to print of its repetitions."""
    failed = [r for r in results if r.get('error_occurred')]
    if failed:
        sys.exit('run_micro.py: %s: %s' % (failed[0]['name'], failed[0]['error_message']))
    subjects = {}
    spreads = {r['run_name']: r for r in results if r.get('aggregate_name') == 'cv'}
    # They ran in turns; their tables do not.
    for result in sorted(results, key=lambda r: (r['family_index'],
                                                 r['per_family_instance_index'])):
        if result.get('aggregate_name') == 'median':
            subject, _, parameter = result['run_name'].partition('/')
            spread = spreads[result['run_name']]
            subjects.setdefault(subject, []).append((
                parameter.replace(':', ' = '),
                time_text(result['cpu_time'] * SECONDS_OF[result['time_unit']]),
                '%.1f %%' % (100.0 * spread['cpu_time']),
                rate_text(result.get('items_per_second'))))
    return subjects


def table(subjects):
    lines = ['| subject | parameter | median time | spread | items a second |',
             '|---|---|---|---|---|']
    for subject, rows in subjects.items():
        lines += ['| `%s` | %s |' % (subject, ' | '.join(row)) for row in rows]
    return '\n'.join(lines)


def write_report(subjects, repetitions, arguments, out):
    text = '\n'.join(heading('Micro-benchmarks', 'run_micro.py', arguments) + [
        '- CPU time on one core, the median of %d repetitions; spread is their standard deviation over '
        'their mean; items are beams, look-ups or tries' % repetitions,
        '- scenes are simulated under fixed seeds', '',
        table(subjects), ''])
    with open(os.path.join(out, 'MICRO.md'), 'w') as file:
        file.write(text)
    print(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--out', default=default_folder())
    parser.add_argument('--build', help='folder to build in and to keep')
    parser.add_argument('--repetitions', type=int, default=5)
    parser.add_argument('--filter', default='.', help='regular expression of names to run')
    arguments = parser.parse_args()
    if arguments.repetitions < 2:
        parser.error('--repetitions: %d is not allowed; allowed: at least 2' % arguments.repetitions)
    os.makedirs(arguments.out, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        program = build(arguments.build or folder)
        results = measure(program, folder, arguments.repetitions, arguments.filter)
    write_report(medians(results), arguments.repetitions, sys.argv[1:], arguments.out)


if __name__ == '__main__':
    main()
