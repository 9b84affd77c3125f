"""What the tests of benchmark/reproduce share: where its modules are, and files and programs."""

import json
import os
import subprocess
import sys

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
WORKFLOW = os.path.join(SOURCE, 'benchmark', 'reproduce')
sys.path.insert(0, WORKFLOW)

# Where the programs are, set by CMake; without it they are those of the sourced workspace.
PROGRAMS = os.environ.get('MATCHBOX_PROGRAMS')


def read_text(*path):
    with open(os.path.join(*path), encoding='utf-8') as file:
        return file.read()


def write(folder, name, content):
    path = os.path.join(folder, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, 'w') as file:
        file.write(content if isinstance(content, str) else json.dumps(content))


def run(*command, folder=None):
    environment = dict(os.environ)
    if PROGRAMS:
        environment['PATH'] = PROGRAMS + os.pathsep + environment.get('PATH', '')
    return subprocess.run(command, env=environment, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True)
