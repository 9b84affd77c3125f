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
