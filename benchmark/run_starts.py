#!/usr/bin/env python3
"""Lets a robot begin anywhere on a recorded drive, without a word, in the map of that drive: how soon it is found.

Each recording is mapped; then every STEP-th scan is a start, localised with slam/update_map=false until it has gone WAY
metres. The poses of the map itself are the truth: what is more than 1 m or 10 degrees from them while sure is wrong.
With the workspace sourced:
run_starts.py --out DIR --bags intel.bag ... [--step 20] [--way 60] [--from 0.0] [--set section/option=value ...]
Writes DIR/starts.json (a row a start) and DIR/STARTS.md (a row a recording).
"""
import argparse
import concurrent.futures
import math
import pathlib
import statistics

from run_faults import SURE, error, output_of, read_scans, read_tum, sets_of, share, write_study

MOST_OFF = 1.0  # [m]
MOST_TURNED = math.radians(10.0)


def moved(a, b):
    return math.hypot(a[0] - b[0], a[1] - b[1])


def weigh(out, true):
    """How many scans and metres it took to be found, and whether it was ever sure of another place."""
    rows, stamps = read_scans(out)
    live = read_tum(out / "trajectory_live.tum")
    sure = [row["state"] in SURE for row in rows]
    found = next((i for i, is_sure in enumerate(sure) if is_sure), None)
    known = [(stamp, is_sure) for stamp, is_sure in zip(stamps, sure) if stamp in true]
    off = [error(live[stamp], true[stamp]) for stamp, is_sure in known if is_sure]
    way = [true[stamp] for stamp in stamps[:None if found is None else found + 1] if stamp in true]
    return {"found_scans": None if found is None else found + 1,
            "found_m": None if found is None else sum(map(moved, way, way[1:])),
            "found_s": None if found is None else stamps[found] - stamps[0],
            "wrong": sum(m > MOST_OFF or turn > MOST_TURNED for m, turn in off),
            "lost_again": found is not None and not all(sure[found:])}


def one_start(bag, folder, begin, first, true, arguments):
    stamps = [stamp for stamp in sorted(true) if stamp >= begin]
    way, last = 0.0, stamps[0]
    for a, b in zip(stamps, stamps[1:]):
        way, last = way + moved(true[a], true[b]), b
        if way > arguments.way:
            break
    out = folder / f"from_{begin:.3f}"
    sets = sets_of(["slam/update_map=false", *arguments.overrides])
    half = 0.001  # [s] so that rounding leaves no scan out
    output_of("map_bag", bag, "--map", folder / "map" / "map.slam", "--out", out, "--quiet", *sets,
              "--start", max(0.0, begin - first - half), "--duration", last - begin + 2 * half)
    row = {"bag": bag.stem, "begin": begin, **weigh(out, true)}
    if not arguments.keep:
        for file in out.iterdir():
            file.unlink()
        out.rmdir()
    return row


def starts_of(bag, arguments):
    folder = arguments.out / bag.stem
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "map" / "map.slam").exists():
        output_of("map_bag", bag, "--out", folder / "map", "--quiet")
    true = read_tum(folder / "map" / "trajectory.tum")
    stamps = sorted(true)
    # The bag may begin before its first scan.
    first = stamps[0] - float(arguments.lead)
    begins = stamps[int(arguments.begin * len(stamps))::arguments.step]
    return [(bag, folder, begin, first, true, arguments) for begin in begins]


def table(rows):
    lines = ["| recording | starts | found | after, median [scans] | 95 of 100 | way, median [m] | 95 of 100 | starts wrong | lost again |",
             "|" + "---|" * 9]
    for bag in dict.fromkeys(row["bag"] for row in rows):
        some = [row for row in rows if row["bag"] == bag]
        found = [row for row in some if row["found_scans"] is not None]
        scans, ways = ([row[key] for row in found] or [math.nan] for key in ("found_scans", "found_m"))
        lines.append(f"| {bag} | {len(some)} | {100.0 * len(found) / len(some):.0f} % | {statistics.median(scans):.0f} | "
                     f"{share(scans, 0.95):.0f} | {statistics.median(ways):.1f} | {share(ways, 0.95):.1f} | "
                     f"{sum(row['wrong'] > 0 for row in some)} | {sum(row['lost_again'] for row in some)} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--bags", type=pathlib.Path, nargs="+", required=True)
    parser.add_argument("--step", type=int, default=20)
    parser.add_argument("--way", type=float, default=60.0, help="[m]")
    parser.add_argument("--from", type=float, default=0.0, dest="begin", help="share of the scans that are no starts")
    parser.add_argument("--lead", type=float, default=0.0, help="[s] that bags begin before their first scan")
    parser.add_argument("--set", action="append", default=[], dest="overrides")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", action="store_true", help="keep what map_bag writes of each start")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    tasks = [task for bag in arguments.bags for task in starts_of(bag, arguments)]
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        rows = list(pool.map(lambda task: one_start(*task), tasks))
    write_study("starts", rows, table(rows), arguments)


if __name__ == "__main__":
    main()
