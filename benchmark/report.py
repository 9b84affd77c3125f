"""What the reports share: what each says first (machine, commit, command), and how programs are run."""

import datetime
import os
import platform
import subprocess
import sys

SOURCE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def run(command):
    """The standard output of a program that must succeed."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit('%s: exit code %d: %s' % (' '.join(command), done.returncode, done.stderr.strip()))
    return done.stdout


def program(name):
    """The command that runs a program of the package."""
    return ['rosrun', 'matchbox_slam', name]


def simulate(world, seed, folder, *options):
    """The paths of a simulated bag and its truth."""
    bag = os.path.join(folder, '%s-%d.bag' % (world, seed))
    truth = os.path.join(folder, '%s-%d.tum' % (world, seed))
    run(program('simulate') + ['--world', world, '--seed', str(seed), '--bag', bag,
                               '--truth', truth] + list(options))
    return bag, truth


def default_folder():
    """Where the newest report of each program belongs; older ones are in the history of the folder."""
    return os.path.join(SOURCE, 'benchmark', 'reports', 'current')


def machine():
    model = platform.machine()
    with open('/proc/cpuinfo') as file:
        for line in file:
            if line.startswith('model name'):
                model = line.split(':', 1)[1].strip()
                break
    return '%s, %d cores, %s' % (model, os.cpu_count(), platform.platform())


def commit():
    """The commit, and whether anything but reports was changed since."""
    name = run(['git', '-C', SOURCE, 'describe', '--always']).strip()
    changed = run(['git', '-C', SOURCE, 'status', '--porcelain', '--', '.', ':!benchmark/reports'])
    return name + ('-dirty' if changed.strip() else '')


def heading(title, program, arguments):
    """The first lines of a report in Markdown."""
    return ['# %s, %s' % (title, datetime.date.today().isoformat()), '',
            '- machine: ' + machine(),
            '- commit: ' + commit(),
            '- command: `%s`' % ' '.join(['benchmark/' + program] + arguments)]
