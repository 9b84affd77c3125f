"""Where the programs of the package are, and which ones they are."""

import glob
import hashlib
import os
import shutil
import subprocess

PROGRAMS = ('simulate', 'match_pairs', 'map_bag', 'evaluate')
SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


class Missing(Exception):
    """A program that is needed is not there."""


def libexec_folders():
    """The folders of the sourced catkin workspaces in which `rosrun` looks."""
    if not shutil.which('catkin_find'):
        return []
    done = subprocess.run(['catkin_find', '--libexec', 'matchbox_slam'], stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, text=True)
    return done.stdout.split('\n')


def find():
    """The paths of all programs, by name."""
    path = os.pathsep.join([folder for folder in libexec_folders() if folder] +
                           [os.environ.get('PATH', '')])
    found = {name: shutil.which(name, path=path) for name in PROGRAMS}
    for name in PROGRAMS:
        if not found[name]:
            raise Missing('the program %s is missing: build the package and source its '
                          'devel/setup.bash' % name)
    return found


def fingerprint(programs):
    """Changes whenever a program or library of the package does, so that results are made anew."""
    digest = hashlib.sha256()
    library_folder = os.path.dirname(os.path.dirname(programs['map_bag']))
    for path in sorted(programs.values()) + sorted(
            glob.glob(os.path.join(library_folder, 'libmatchbox_slam_*.so'))):
        with open(path, 'rb') as file:
            digest.update(file.read())
    return digest.hexdigest()[:16]


def commit():
    """Of the source tree; an installed package has none."""
    try:
        done = subprocess.run(['git', '-C', SOURCE, 'describe', '--always', '--dirty'],
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    except OSError:
        return None
    return done.stdout.strip() or None
