#!/usr/bin/python3
"""list_packages.py SYSTEM programs|all PACKAGE.xml...

Prints the packages of SYSTEM, such as debian-12, that the keys in these files stand for by rosdep.yaml beside this
script, one a line. `programs` takes what building takes, `all` what running and testing take too. Conditions in the
files read the environment. Not by rosdep: its versions differ in what they can be asked.
"""

import os
import pathlib
import sys

import yaml
from catkin_pkg.package import parse_package

CODENAMES = {'debian-11': 'bullseye', 'debian-12': 'bookworm', 'debian-13': 'trixie', 'ubuntu-20.04': 'focal'}


def keys_of(files, kind):
    packages = [parse_package(str(file)) for file in files]
    keys = set()
    for package in packages:
        package.evaluate_conditions(os.environ)
        needs = package.buildtool_depends + package.build_depends
        if kind == 'all':
            needs += package.exec_depends + package.test_depends
        keys |= {need.name for need in needs if need.evaluated_condition}
    return keys - {package.name for package in packages}


def packages_of(key, system, names):
    distribution = system.split('-')[0]
    known = names.get(key, {}).get(distribution)
    if isinstance(known, dict):
        known = known.get(CODENAMES.get(system), known.get('*'))
    if known is None and distribution == 'ubuntu':
        return ['ros-noetic-' + key.replace('_', '-')]
    if known is None:
        sys.exit(f"rosdep.yaml names no package for '{key}' on {system}")
    return known


def main():
    system, kind, *files = sys.argv[1:]
    names = yaml.safe_load(pathlib.Path(__file__).with_name('rosdep.yaml').read_text())
    found = set()
    for key in keys_of(files, kind):
        found.update(packages_of(key, system, names))
    print('\n'.join(sorted(found)))


if __name__ == '__main__':
    main()
