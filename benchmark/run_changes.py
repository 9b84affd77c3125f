#!/usr/bin/env python3
"""Maps rooms, changes them, and drives on in the old map: whether the new map shows what is there now.

After furniture and door leaves were moved, things taken and walls built (--changes), a robot goes on with the map for
three laps. What a robot sees there that begins anew on the same scans is the truth, of what can be seen. With the
workspace sourced:
run_changes.py --out DIR [--seeds 5] [--changes='--moved 0.1 --taken 0.05 --walls 6'] [--set section/option=value ...]
Writes DIR/changes.json (a row a seed) and DIR/CHANGES.md. What is gone or has come is a cluster of cells of 5 cm; it is
shown wrongly where more than a fifth of them are.
"""
import json
import math
import re

import numpy as np
from scipy.ndimage import label
from scipy.spatial import cKDTree

from run_faults import (SURE, aligned, composed, error, inverse, is_wrong, output_of, read_scans, read_tum, rows_of_seeds,
                        sets_of, share, study_parser, text, write_study)

NEAR = 0.1  # [m] as walls are drawn in one map and another
LEAST = 4  # cells that are something
WRONG = 0.2  # share of them
OCCUPIED, FREE, UNKNOWN = range(3)


class Map:
    """The cells of a map.yaml, in the world."""

    def __init__(self, folder, truth):
        lines = dict(line.split(": ", 1) for line in (folder / "map.yaml").read_text().splitlines() if ": " in line)
        self.origin = [float(value) for value in lines["origin"].strip("[]").split(",")][:2]
        self.resolution = float(lines["resolution"])
        data = (folder / lines["image"]).read_bytes()
        header = re.match(rb"P5\s+(?:#[^\n]*\n\s*)*(\d+)\s+(\d+)\s+\d+\s", data)
        columns, rows = int(header[1]), int(header[2])
        grey = np.frombuffer(data, np.uint8, columns * rows, header.end()).reshape(rows, columns)[::-1]
        self.cells = np.select([grey < 100, grey > 250], [OCCUPIED, FREE], UNKNOWN)
        poses = read_tum(folder / "trajectory.tum")
        stamp, pose = next(iter(aligned(truth, poses).items()))
        self.world_from_map = composed(truth[stamp], inverse(pose))
        self.walls = self.points(OCCUPIED)
        self.tree = cKDTree(self.walls)

    def points(self, kind):
        rows, columns = np.nonzero(self.cells == kind)
        return placed(self.world_from_map, np.column_stack((columns + 0.5, rows + 0.5)) * self.resolution + self.origin)

    def at(self, points):
        """What it shows at points of the world."""
        cells = np.floor((placed(inverse(self.world_from_map), points) - self.origin) / self.resolution).astype(int)
        inside = np.all((cells >= 0) & (cells < self.cells.shape[::-1]), axis=1)
        shown = np.full(len(points), UNKNOWN)
        shown[inside] = self.cells[cells[inside, 1], cells[inside, 0]]
        return shown

    def has_wall(self, points, within=NEAR):
        return self.tree.query(points, distance_upper_bound=within)[0] <= within


def placed(pose, points):
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return points @ np.array(((c, s), (-s, c))) + pose[:2]


def is_free(seen, points):
    return (seen.at(points) == FREE) & ~seen.has_wall(points)


def things_of(points, is_wrong_there):
    """How many clusters there are, and how many of them are shown wrongly."""
    if not len(points):
        return 0, 0
    cells = np.floor(points / 0.05).astype(int)
    cells -= cells.min(axis=0)
    grid = np.zeros(cells.max(axis=0) + 1, bool)
    grid[tuple(cells.T)] = True
    numbers = label(grid, np.ones((3, 3)))[0][tuple(cells.T)]
    sizes, wrong = np.bincount(numbers), np.bincount(numbers, is_wrong_there)
    some = sizes >= LEAST
    return int(some.sum()), int((some & (wrong > WRONG * sizes)).sum())


def compared(before, after, seen):
    """What a map shows after changes that it has seen, against a map before them, and one that knows nothing else."""
    was, come = before.walls, seen.walls[~before.has_wall(seen.walls)]
    gone = was[is_free(seen, was)]
    known = np.concatenate((was, before.points(FREE)))
    kept = known[(seen.at(known) == UNKNOWN) & ~seen.has_wall(known)]
    return {"gone": things_of(gone, after.has_wall(gone, 0.5 * NEAR)), "come": things_of(come, ~after.has_wall(come)),
            "ghosts": int(is_free(seen, after.walls).sum()), "holes": int((~after.has_wall(seen.walls)).sum()),
            "walls": len(seen.walls), "kept": len(kept), "forgotten": int((after.at(kept) == UNKNOWN).sum())}


def localised(folder, truth, world_from_map):
    rows, stamps = read_scans(folder)
    live = read_tum(folder / "trajectory_live.tum")
    sure = [stamp for row, stamp in zip(rows, stamps) if row["state"] in SURE]
    errors = [error(composed(world_from_map, live[stamp]), truth[stamp]) for stamp in sure]
    ways = [way for way, _ in errors]
    return {"scans": len(rows), "lost": sum(row["state"] == "lost" for row in rows), "sure": len(sure),
            "wrong": sum(is_wrong(*one) for one in errors), "p95_m": share(ways, 0.95), "worst_m": share(ways, 1.0)}


def one_seed(seed, arguments):
    folder = arguments.out / str(seed)
    folder.mkdir(parents=True, exist_ok=True)
    sets = sets_of(arguments.overrides)

    def driven(name, *options):
        bag, truth = folder / f"{name}.bag", folder / f"{name}.tum"
        said = output_of("simulate", "--world", arguments.world, "--seed", seed, "--beams", arguments.beams, "--scan-rate",
                         arguments.rate, "--bag", bag, "--truth", truth, *options)
        return bag, read_tum(truth), said

    def mapped(bag, name, *options):
        output_of("map_bag", bag, "--out", folder / name, "--quiet", *options, *sets)
        return folder / name

    bag, true_then, _ = driven("then")
    before = Map(mapped(bag, "before"), true_then)
    bag.unlink()
    bag, true, said = driven("now", "--noise-seed", 1000 + seed, "--start-stamp", 1327600000, "--laps", arguments.laps,
                             "--change-seed", seed, *arguments.changes.split())
    begin = ",".join(f"{value:.6f}" for value in composed(inverse(before.world_from_map), true[min(true)]))
    after = mapped(bag, "after", "--map", folder / "before" / "map.slam", f"--pose={begin}")
    seen = Map(mapped(bag, "seen"), true)
    bag.unlink()
    row = {"seed": seed, "changed": (re.findall(r"changed: (.*)", said) or ["nothing"])[0],
           **compared(before, Map(after, true), seen), **localised(after, true, before.world_from_map)}
    print(json.dumps(row), flush=True)
    return [row]


def table(rows):
    lines = ["| seed | changed | things gone, still shown | come, not shown | cells of ghosts | of holes | of walls | not looked "
             "at, forgotten | scans | lost | sure and wrong | p95 [m] | worst [m] |", "|" + "---|" * 13]
    for row in rows:
        pairs = [", ".join(map(str, row[key])) for key in ("gone", "come")]
        lines.append(f"| {row['seed']} | {row['changed']} | {pairs[0]} | {pairs[1]} | {row['ghosts']} | {row['holes']} | "
                     f"{row['walls']} | {row['kept']}, {row['forgotten']} | {row['scans']} | {row['lost']} | {row['wrong']} | "
                     f"{text(row['p95_m'], 4)} | {text(row['worst_m'], 3)} |")
    return "\n".join(lines) + "\n"


def main():
    parser = study_parser(__doc__, seeds=5, rate=5.0)
    parser.add_argument("--world", default="rooms")
    parser.add_argument("--changes", default="--moved 0.1 --taken 0.05 --walls 6", help="options of simulate")
    parser.add_argument("--laps", type=int, default=3)
    parser.add_argument("--beams", type=int, default=361)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = rows_of_seeds(one_seed, arguments)
    write_study("changes", rows, table(rows), arguments)


if __name__ == "__main__":
    main()
