#!/usr/bin/env python3
"""Whether two builds of the package yield the same bytes: maps every recording and simulated world
with each matcher by both, and compares trajectory.tum and map.pgm.

    compare_results.py BEFORE AFTER [--out DIR] [--data DIR] [--only NAME]... [--jobs N]

BEFORE and AFTER are devel spaces (folders with a setup.bash). The worlds are simulated once, by BEFORE.
Results of BEFORE that are in --out already are taken as they are. Exits 1 when anything differs.
"""

import argparse
import concurrent.futures
import filecmp
import os
import pathlib
import shlex
import subprocess
import sys

MATCHERS = ("olson", "hough", "monte_carlo")
COMPARED = ("trajectory.tum", "map.pgm")

# Name: arguments of simulate.
WORLDS = {
    "rooms": "--world rooms --seed 1",
    "random": "--world random --seed 1",
    "loop": "--world loop --seed 1",
    "corridor": "--world corridor --seed 1",
    "rooms_sweeping": ("--world rooms --seed 3 --duration 60 --beams 360 --field-of-view 6.266 --range-max 12 "
                       "--scan-rate 8 --time-increment 0.000343"),
}

# Name: recording and arguments of map_bag.
RECORDINGS = {
    "aces": "aces.bag",
    "belgioioso": "belgioioso.bag",
    "guardian": "guardian.bag --scan-topic /scan",
    "guardian_two_lasers": "guardian.bag --set scan_topics=[/scan,/hokuyo_back_scan]",
    "hokuyo_handheld": "hokuyo_handheld.bag --no-odom",
    "infinite_corridor": "infinite_corridor.bag",
    "intel": "intel.bag",
    "inverted_laser": "inverted_laser.bag",
    "jarvis": "jarvis_circular.bag --scan-topic /driver_laser_security/laser_scan",
    "jarvis_turning": "jarvis_circular.bag --scan-topic /driver_laser_navigation/laser_scan --no-odom"
                      " --set scan_time_offset=-0.12",
    "seattle": "seattle.bag",
}


def run(space, program, arguments, log):
    """Runs a program of a devel space; true when it succeeded."""
    command = (f"source {shlex.quote(str(space / 'setup.bash'))} && "
               f"exec {shlex.quote(str(space / 'lib/matchbox_slam' / program))} {arguments}")
    with open(log, "w", encoding="utf-8") as output:
        return subprocess.run(["bash", "-c", command], stdout=output, stderr=subprocess.STDOUT,
                              check=False, env=dict(os.environ, LC_ALL="C")).returncode == 0


def simulate(space, folder, only):
    """The worlds' bags, by name; made where they are not there yet."""
    bags = {}
    for name, arguments in WORLDS.items():
        if only and name not in only:
            continue
        bag = folder / f"{name}.bag"
        if not bag.exists() and not run(space, "simulate", f"{arguments} --bag {bag} --truth "
                                        f"{folder / name}.tum", folder / f"{name}.log"):
            sys.exit((folder / f"{name}.log").read_text(encoding="utf-8"))
        bags[name] = str(bag)
    return bags


def map_one(space, name, arguments, matcher, out):
    """The folder with the results; none when mapping failed."""
    folder = out / name / matcher
    if all((folder / file).exists() for file in COMPARED) and out.name == "before":
        return folder
    folder.mkdir(parents=True, exist_ok=True)
    worked = run(space, "map_bag", f"{arguments} --matcher {matcher} --out {folder} --quiet",
                 folder / "log")
    return folder if worked else None


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=pathlib.Path)
    parser.add_argument("after", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("compared"))
    parser.add_argument("--data", type=pathlib.Path,
                        default=os.environ.get("MATCHBOX_DATA", "../shared/data"))
    parser.add_argument("--only", action="append", default=[])
    parser.add_argument("--matcher", action="append", default=[])
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    out = options.out.resolve()
    (out / "bags").mkdir(parents=True, exist_ok=True)

    runs = simulate(options.before.resolve(), out / "bags", options.only)
    for name, arguments in RECORDINGS.items():
        bag = options.data.resolve() / arguments.split()[0]
        if options.only and name not in options.only:
            continue
        if bag.exists():
            runs[name] = f"{bag} {' '.join(arguments.split()[1:])}"
        else:
            print(f"SKIPPED {name}: {bag} is not there")

    different = 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        jobs = {(name, matcher, side): pool.submit(map_one, space.resolve(), name, arguments, matcher,
                                                   out / side)
                for name, arguments in runs.items() for matcher in options.matcher or MATCHERS
                for side, space in (("before", options.before), ("after", options.after))}
        for name in runs:
            for matcher in options.matcher or MATCHERS:
                before, after = (jobs[name, matcher, side].result() for side in ("before", "after"))
                verdict = "equal"
                if before is None or after is None:
                    verdict = f"FAILED {'before' if before is None else 'after'}"
                else:
                    unlike = [file for file in COMPARED
                              if not filecmp.cmp(before / file, after / file, shallow=False)]
                    verdict = f"DIFFERENT {', '.join(unlike)}" if unlike else "equal"
                different += verdict != "equal"
                print(f"{name:20} {matcher:12} {verdict}", flush=True)
    print(f"{len(runs) * len(options.matcher or MATCHERS)} compared, {different} different")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
