#!/usr/bin/env python3
"""Maps recordings as other drives: backwards, mirrored and in parts, which nothing was chosen on (turn_bag.py).

With the workspace sourced: run_turned.py --data DIR [--out DIR] [--set section/option=value ...]
Writes a table of errors, against the poses that came with the recordings, to OUT/TURNED.md.
"""

import argparse
import concurrent.futures
import math
import os
import sys
import tempfile

from report import SOURCE, default_folder, heading, program, run
from run_bags import RECORDINGS, error_of
from run_faults import sets_of

TURN = os.path.join(SOURCE, 'benchmark', 'turn_bag.py')
WAYS = {'backwards': ['--backwards'], 'mirrored': ['--mirrored'], 'both': ['--backwards', '--mirrored'],
        'second half': ['--begin', '0.5'], 'first half backwards': ['--backwards', '--end', '0.5'],
        'the middle half': ['--begin', '0.25', '--end', '0.75'],
        'without its first 0.4, backwards': ['--backwards', '--begin', '0.4'],
        'without its first third, mirrored': ['--mirrored', '--begin', '0.33']}


def error_as(recording, way, options, folder):
    """The error [m] of one recording driven one way."""
    name, file, flags, truth = recording
    place = os.path.join(folder, f'{name} {way}'.replace(' ', '_'))
    bag, tum = place + '.bag', place + '.tum'
    run([sys.executable, TURN, os.path.join(options.data, file + '.bag'), bag, *WAYS[way],
         '--truth', os.path.join(options.data, truth[2]), tum])
    run(program('map_bag') + [bag, '--out', place, '--quiet', *flags, *sets_of(options.overrides)])
    os.remove(bag)
    return error_of(os.path.join(place, 'trajectory.tum'), ['ate', '--truth', tum])


def table(recordings, errors):
    lines = ['| recording | ' + ' | '.join(WAYS) + ' |', '|---' * (len(WAYS) + 1) + '|']
    for recording in recordings:
        lines.append(f'| `{recording[0]}` | ' + ' | '.join(f'{errors[recording[0], way]:.3f}' for way in WAYS) + ' |')
    mean = math.exp(sum(math.log(error) for error in errors.values()) / len(errors))
    return lines + ['', f'Geometric mean {mean:.4f} m, worst {max(errors.values()):.3f} m.']


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--data', required=True, help='folder of recordings')
    parser.add_argument('--out', default=default_folder(), help='folder of the report')
    parser.add_argument('--set', dest='overrides', action='append', default=[], help='option of map_bag')
    options = parser.parse_args()
    recordings = [one for one in RECORDINGS if one[3] and one[3][-1].endswith('.corrected.tum')]
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(2) as pool:
        runs = {(one[0], way): pool.submit(error_as, one, way, options, folder) for one in recordings for way in WAYS}
        errors = {key: task.result() for key, task in runs.items()}
    lines = heading('Recordings as other drives', 'run_turned.py', sys.argv[1:]) + [
        '- matcher `olson`, ATE [m] after alignment', ''] + table(recordings, errors)
    with open(os.path.join(options.out, 'TURNED.md'), 'w') as file:
        file.write('\n'.join(lines) + '\n')


if __name__ == '__main__':
    main()
