"""Where the programs of the package are, and which ones they are."""

import hashlib
import os
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree

PROGRAMS = ('simulate', 'match_pairs', 'map_bag', 'evaluate')
LOAD_MATCHERS = ('match_pairs', 'map_bag')


class Missing(Exception):
    """A program that is needed is not there."""


def lines_of(*command):
    """What a program prints; nothing where it is missing."""
    if not shutil.which(command[0]):
        return []
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return done.stdout.splitlines()


def find():
    """The paths of all programs, by name: where `rosrun` looks, then on the PATH."""
    path = os.pathsep.join(lines_of('catkin_find', '--libexec', 'matchbox_slam') +
                           [os.environ.get('PATH', '')])
    found = {name: shutil.which(name, path=path) for name in PROGRAMS}
    for name in PROGRAMS:
        if not found[name]:
            raise Missing('the program %s is missing: build the package and source its '
                          'devel/setup.bash' % name)
    return found


def libraries(program):
    """The package's own libraries that a program is linked with."""
    words = [line.split() for line in lines_of('ldd', program) if 'matchbox_slam' in line]
    return [line[2] for line in words if len(line) > 2]


def matcher_libraries(program):
    """The libraries of all matchers that pluginlib may load: the package's own, and other people's."""
    folders = os.environ.get('CMAKE_PREFIX_PATH', '').split(os.pathsep)
    found = [os.path.join(os.path.dirname(os.path.dirname(program)), 'libmatchbox_slam_plugins.so')]
    for line in lines_of('rospack', 'plugins', '--attrib=plugin', 'matchbox_slam'):
        for library in ElementTree.parse(line.split(None, 1)[1]).iter('library'):
            if any(entry.get('base_class_type') == 'matchbox_slam::ScanMatcher' for entry in library):
                found += [os.path.join(folder, library.get('path') + '.so') for folder in folders]
    return [path for path in found if os.path.isfile(path)]


def fingerprint(program):
    """Changes whenever what a program consists of does, so that its results are made anew."""
    files = [program] + libraries(program)
    if os.path.basename(program) in LOAD_MATCHERS:
        files += matcher_libraries(program)
    if os.path.basename(program) == 'evaluate':
        plot = os.path.join(os.path.dirname(program), 'plot_evaluation')
        files += [plot] if os.path.isfile(plot) else []
    digest = hashlib.sha256()
    for path in sorted(set(map(os.path.realpath, files))):
        with open(path, 'rb') as file:
            digest.update(file.read())
    return digest.hexdigest()[:16]
