#!/usr/bin/env python3
"""Matches pairs of simulated scans and writes a report of error, success, time and honesty.

Source the workspace first (`source .workspace/devel/setup.bash`), then:

    benchmark/run_pairs.py [--out DIR] [--pairs N] [--seed N] [--matcher NAME]...
"""

import argparse
import json
import os
import sys
import tempfile

from report import default_folder, heading, program, run, simulate

NO_NOISE = ['--range-noise', '0', '--dropout', '0']

# What is asked, the world, options of the simulation, options of match_pairs
TASKS = [
    ('rooms, 1 cm noise', 'rooms', [], []),
    ('rooms', 'rooms', NO_NOISE, []),
    ('rooms, good guess', 'rooms', NO_NOISE, ['--error-xy', '0', '--error-theta', '0']),
    ('rooms, bad guess: 1 m, 45°', 'rooms', [], ['--error-xy', '1', '--error-theta', '0.7854']),
    ('random, 1 cm noise', 'random', [], []),
    ('random', 'random', NO_NOISE, []),
    ('random, good guess', 'random', NO_NOISE, ['--error-xy', '0', '--error-theta', '0']),
    ('corridor, 1 cm noise', 'corridor', [], []),
]


def measure(task, matchers, pairs, seed, folder):
    """The rows of a task, one a matcher."""
    name, world, simulation, options = task
    bag, truth = simulate(world, 1, folder, *simulation)
    out = os.path.join(folder, 'pairs')
    command = program('match_pairs') + [bag, '--truth', truth, '--out', out, '--quiet',
                                        '--pairs', str(pairs), '--seed', str(seed)] + options
    for matcher in matchers:
        command += ['--matcher', matcher]
    run(command)
    with open(os.path.join(out, 'summary.json')) as file:
        return [dict(row, task=name) for row in json.load(file)['matchers']]


def number(value, decimals):
    if value is None:
        return '–'
    return value if isinstance(value, str) else '%.*f' % (decimals, value)


def table(rows):
    lines = ['| pairs | matcher | success % | error mm, median / 95 % | mrad, median / 95 % | search alone: success % '
             '| mm, median / 95 % | mrad, median / 95 % | mean NEES | error / bound | of unknown walls '
             '| ms, median / 95 % |',
             '|---|---|---|---|---|---|---|---|---|---|---|---|']
    for row in rows:
        translation, heading_error, time = row['translation_mm'], row['heading_mrad'], row['time_ms']
        known = row['cramer_rao'] or {}
        unknown = row['cramer_rao_unknown_walls'] or {}
        search = row['search']
        lines.append('| %s | %s | %.1f | %.2f / %.2f | %.3f / %.3f | %.1f | %.2f / %.2f | %.3f / %.3f | %s | %s | %s '
                     '| %.2f / %.2f |' % (
            row['task'], row['matcher'], 100.0 * row['success_rate'], translation['median'],
            translation['p95'], heading_error['median'], heading_error['p95'], 100.0 * search['success_rate'],
            search['translation_mm']['median'], search['translation_mm']['p95'], search['heading_mrad']['median'],
            search['heading_mrad']['p95'], number(row['nees_mean'], 2), number(known.get('error_to_bound'), 2),
            number(unknown.get('error_to_bound'), 2), time['median'], time['p95']))
    return '\n'.join(lines)


def bounds(rows):
    """The bounds of each task, in the median over its pairs, and the median errors beside them."""
    lines = ['| pairs | least deviation, world known: mm | mrad | walls unknown: mm | mrad '
             '| median errors / world known: mm | mrad |', '|---|---|---|---|---|---|---|']
    for task in dict.fromkeys(row['task'] for row in rows):
        row = next(row for row in rows if row['task'] == task)
        known, unknown = row['cramer_rao'], row['cramer_rao_unknown_walls']
        if not known:
            continue
        cells = [number(bound[key], 3) for bound in (known, unknown)
                 for key in ('bound_translation_mm', 'bound_heading_mrad')]
        for error, key in (('translation_mm', 'bound_translation_mm'),
                           ('heading_mrad', 'bound_heading_mrad')):
            bound = known[key]
            cells.append('–' if isinstance(bound, str) else number(row[error]['median'] / bound, 2))
        lines.append('| ' + ' | '.join([task + ', ' + row['matcher']] + cells) + ' |')
    lines += ['', 'The last two columns are medians over a standard deviation: of a perfect matcher 0.67 in heading, '
              'and 0.67 to 0.83 in translation.']
    return '\n'.join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--out', default=default_folder())
    parser.add_argument('--pairs', type=int, default=1000)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--matcher', action='append')
    arguments = parser.parse_args()
    os.makedirs(arguments.out, exist_ok=True)
    rows = []
    for task in TASKS:
        with tempfile.TemporaryDirectory() as folder:
            rows += measure(task, arguments.matcher or ['olson', 'hough', 'monte_carlo'], arguments.pairs,
                            arguments.seed, folder)
    text = '\n'.join(heading('Pairs of scans', 'run_pairs.py', sys.argv[1:]) + [
        '- %d pairs of scans half a second apart, seed %d, worlds of seed 1; the guess is off by up to '
        '0.2 m and 0.2 rad unless said otherwise' % (arguments.pairs, arguments.seed),
        '- success: within 20 mm and 10 mrad of the truth; NEES: 3 is an honest covariance',
        '- search alone: where a search ended, before the refinement that all matchers end in',
        '- error / bound: root mean squared error of the successes in units of the Cramér–Rao bound '
        '(Censi 2007), which knows the world exactly; of unknown walls: in units of the bound of two scans '
        'of straight walls that nobody knows', '', table(rows), '', bounds(rows), ''])
    with open(os.path.join(arguments.out, 'PAIRS.md'), 'w') as file:
        file.write(text)
    print(text)


if __name__ == '__main__':
    main()
