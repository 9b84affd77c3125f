#!/usr/bin/env python3
"""Runs all benchmarks one after the other and writes their reports into one folder.

Source the workspace first (`source .workspace/devel/setup.bash`), then:

    benchmark/run.py [--out DIR] [--matcher NAME]... [--other RECORDING:SYSTEM=FILE.tum]...

BAGS.md: whole programs over bags (run_bags.py); PAIRS.md: scan matching alone (run_pairs.py); MICRO.md: the
parts (run_micro.py). On an idle machine; takes half an hour and more.
"""

import argparse
import os
import subprocess
import sys


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--out', help='default: benchmark/reports/current')
    parser.add_argument('--matcher', action='append', default=[])
    parser.add_argument('--other', action='append', default=[])
    arguments = parser.parse_args()
    matchers = [word for name in arguments.matcher for word in ('--matcher', name)]
    others = [word for other in arguments.other for word in ('--other', other)]
    here = os.path.dirname(os.path.abspath(__file__))
    # The micro-benchmarks first: they need Google Benchmark, and soon say so where it is missing.
    for script, options in (('run_micro.py', []), ('run_bags.py', matchers + others),
                            ('run_pairs.py', matchers)):
        out = ['--out', arguments.out] if arguments.out else []
        command = [sys.executable, os.path.join(here, script)] + out + options
        if subprocess.run(command).returncode != 0:
            sys.exit('run.py: %s failed' % script)


if __name__ == '__main__':
    main()
