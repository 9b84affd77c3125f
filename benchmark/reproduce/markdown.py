"""Writes the tables of a run as Markdown, for reports that are kept and for doc/reproduce.md."""

import tables
from experiments import TESTS


def cell(text):
    return text.replace('|', r'\|').replace('\n', ' ').strip()


def table(table):
    rows = [cells + [''] * (len(table.header) - len(cells)) for _, cells in table.rows]
    lines = [' | '.join(map(cell, cells)) for cells in [table.header] + rows]
    lines.insert(1, ' | '.join(['---'] * len(table.header)))
    return '\n'.join('| %s |' % line for line in lines)


def document(summary, times):
    options = summary['options']
    lines = ['# The paper\'s experiments', '', '- measured on: ' + '; '.join(times['machines']),
             '- commit: ' + summary['commit'],
             '- command: `reproduce`, size %s, seed %s, recording %s' % (
                 options['size'], options['seed'], ', '.join(options['bags'])), '']
    for name, test in TESTS.items():
        lines += ['## Table %s: test %s, %s' % (test.table, name, test.title), '',
                  table(tables.test_table(name, summary, times)), '']
    lines += ['## Searches alone', '', table(tables.search_table(times)), '',
              '## Beyond the basin', '', table(tables.basin_table(summary, times)), '',
              '## Worse scans', '', table(tables.hard_table(summary, times)), '']
    lines += ['## Table I', '', table(tables.complexity_table(times)), '', '## Searches of a given window', '',
              table(tables.budget_table(times)), '', '## Figure 6', '', table(tables.map_table(summary, times)), '',
              '## What is missed of what is asked, or failed', '']
    misses = summary['failed'] + summary['missed'] + times['missed']
    return '\n'.join(lines + ['- ' + miss for miss in misses or ['nothing']] + [''])
