"""Reading and writing of the files between the jobs."""

import json
import os


def read_json(path):
    with open(path) as file:
        return json.load(file)


def write_text(path, text):
    """Replaces a file as a whole."""
    part = path + '.part'
    with open(part, 'w', encoding='utf-8') as file:
        file.write(text)
    os.replace(part, path)


def write_json(path, value):
    write_text(path, json.dumps(value, indent=1, sort_keys=True, ensure_ascii=False) + '\n')


def log_lines(path):
    """Of a job: its commands, which begin with '+ ', and what the programs said."""
    try:
        with open(path, errors='replace') as file:
            lines = [line.rstrip() for line in file if line.strip()]
    except OSError:
        lines = []
    return ([line[2:] for line in lines if line.startswith('+ ')],
            [line for line in lines if not line.startswith('+')])


def reason(log):
    """Why a job left no result, by its log."""
    commands, said = log_lines(log)
    if said:
        return said[-1]
    return ('it was ended from outside' if commands else
            'not made: the run was stopped, or something that it needs failed')


class Failed(Exception):
    """A job left no result; says why."""


def require(paths, log):
    """All of a job's results have to be there."""
    if not all(map(os.path.exists, paths)):
        raise Failed(reason(log))
