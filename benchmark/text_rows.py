"""Text files of numbers, as the programs beside this one read them."""

import math

TUM = "TUM file: each line has to be eight numbers, stamp x y z qx qy qz qw"


class Mistake(Exception):
    """What the user gave is not as it has to be: the text says what, and what would do."""


def read_rows(path, columns, what):
    """The numbers of each line that is no comment; there are some, and all are finite."""
    try:
        with open(path) as file:
            rows = [[float(word) for word in line.split()] for line in file if line.strip() and line[0] != "#"]
    except OSError as mistake:
        raise Mistake(f"'{path}' cannot be read: {mistake.strerror or mistake}")
    except ValueError:
        rows = []
    if not rows or any(len(row) != columns or not all(map(math.isfinite, row)) for row in rows):
        raise Mistake(f"'{path}' is no {what}")
    return rows
