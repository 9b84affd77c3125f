#!/usr/bin/env python3
"""Writes the tables of a run as Markdown, for reports that are kept and for the README."""

import argparse

from experiments import BASELINE, NAMES, NOISES, PAPER, TESTS
from files import read_json, write_text
from page import number


def table(header, rows):
    lines = ['| ' + ' | '.join(cells) + ' |' for cells in [header, ['---'] * len(header)] + rows]
    return '\n'.join(lines)


def paper_text(test, matcher):
    """Time, errors along x and y, and of the heading."""
    if matcher == BASELINE:
        return ['–', '–', '–']
    time, x, y, heading = PAPER[test][matcher]
    shift = '–' if x is None else '%g, %g' % (1000.0 * x, 1000.0 * y)
    return ['%g' % (1000.0 * time), shift, '%g' % (1000.0 * heading)]


def tests(summary, times):
    time_of = {(row['test'], row['noise'], row['matcher']): row['time_ms'] for row in times['tests']}
    rows = []
    for row in summary['tests']:
        time = time_of[row['test'], row['noise'], row['matcher']]
        rows.append([row['test'], '%g cm' % (100.0 * NOISES[row['noise']]), NAMES[row['matcher']]] +
                    paper_text(row['test'], row['matcher']) + [
                        '%.2f / %.2f' % (time['median'], time['p95']),
                        '%.2f / %.2f' % (row['translation_mm']['median'], row['translation_mm']['p95']),
                        '%.3f / %.3f' % (row['heading_mrad']['median'], row['heading_mrad']['p95']),
                        '%.1f' % (100.0 * row['success_rate'])])
    return table(['test', 'range noise', 'matcher', 'paper: ms', 'mm along x, y', 'mrad',
                  'ours: ms, median / 95 %', 'mm', 'mrad', 'success %'], rows)


def complexities(times):
    return table(
        ['matcher', 'paper', 'time against', 'measured from, to', 'exponent', 'fixed cost, ms'],
        [[NAMES[row['matcher']], 'O(%s)' % row['paper'], row['quantity'],
          '{:,} to {:,}'.format(row['x'][0], row['x'][-1]), '%.2f' % row['fit']['exponent'],
          '%.2f' % row['fit']['fixed']] for row in times['complexity']])


def maps(summary):
    odometry = next((row['odometry'] for row in summary['maps'] if 'odometry' in row), {})
    rows = []
    for row in summary['maps']:
        quality = row['quality']
        error = row.get('trajectory', odometry if row['matcher'] == BASELINE else {})
        rows.append([NAMES[row['matcher']], number(error.get('rmse_m'), '%.4f'),
                     '%.2f' % (100.0 * quality['occupied_of_known']), str(quality['corners']),
                     str(quality['enclosed_areas'])])
    return table(['map of figure 6', 'ATE m', 'occupied of known %', 'corners', 'enclosed areas'], rows)


def document(summary, times):
    misses = ['- ' + miss for miss in summary['missed'] + times['missed']] or ['None.']
    return '\n'.join([
        '# The paper\'s experiments, %s' % times['date'], '', '- machine: ' + times['machine'],
        '- commit: %s, programs %s' % (summary['commit'] or 'unknown', summary['programs']),
        '- command: `reproduce`, size %s, seed %s, recording %s' % (
            summary['options']['size'], summary['options']['seed'],
            ', '.join(summary['options']['bags'])),
        '', '## Tables II to V', '', '%d trials a row, guess off as the test says: %s.' % (
            summary['tests'][0]['pairs'],
            '; '.join('%s: %s' % (name, test.title) for name, test in TESTS.items())),
        '', tests(summary, times), '', '## Table I', '', complexities(times), '', '## Figure 6', '',
        maps(summary), '', '## What is missed of what is asked', ''] + misses + [''])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--summary', required=True)
    parser.add_argument('--times', required=True)
    parser.add_argument('--out', required=True)
    arguments = parser.parse_args()
    write_text(arguments.out, document(read_json(arguments.summary), read_json(arguments.times)))


if __name__ == '__main__':
    main()
