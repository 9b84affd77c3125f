#!/usr/bin/env python3
"""compare.py FOLDER FOLDER...: says what differs between the summaries of runs, times aside. Exits 1 when
something does."""

import json
import os
import sys

from files import read_json


def leaves(value, path=''):
    """Every number and text below a value, by its path."""
    if isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list):
        items = enumerate(value)
    else:
        return {path: value}
    return {key: leaf for name, part in items for key, leaf in leaves(part, '%s/%s' % (path, name)).items()}


def differences(first, second):
    """Lines that say what differs."""
    a, b = leaves(first), leaves(second)
    return ['%s: %s, %s' % (path, json.dumps(a.get(path)), json.dumps(b.get(path)))
            for path in sorted(set(a) | set(b)) if a.get(path) != b.get(path)]


def main(folders):
    if len(folders) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    summaries = [read_json(os.path.join(folder, 'summary.json')) for folder in folders]
    found = False
    for folder, summary in zip(folders[1:], summaries[1:]):
        lines = differences(summaries[0], summary)
        found = found or bool(lines)
        print('%s and %s: %s' % (folders[0], folder,
                                 '%d differences' % len(lines) if lines else
                                 'the same %d values' % len(leaves(summary))))
        for line in lines:
            print('  ' + line)
    return 1 if found else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
