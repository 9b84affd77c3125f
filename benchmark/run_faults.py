#!/usr/bin/env python3
"""Drives simulated robots through faults and tells what became of pose and map.

Worlds x faults x matchers x seeds. Each run: `simulate --fault`, then `map_bag`; the truth is known.
With the workspace sourced: run_faults.py --out DIR [--seeds 20] [--set section/option=value ...]
Writes DIR/faults.json (a row a run) and DIR/FAULTS.md (a row for each world, fault and matcher).
With --kidnappings N instead: so many in rooms that are mapped, five on a drive; a robot is found that is tracked where
it is when it is carried away again. With --early-kidnappings N: drives of a minute, carried away after 25 s, where
little is mapped.
"""
import argparse
import collections
import concurrent.futures
import csv
import functools
import json
import math
import os
import pathlib
import shlex
import shutil
import subprocess

FAULTS = {
    "none": [],
    "freeze": ["freeze:random:3"],
    "encoders 2 s": ["encoders:random:2"],
    "encoders 10 s": ["encoders:random:10"],
    "heading slip": ["heading_slip:random:3:-0.8"],
    "way slip": ["way_slip:random:3:-0.9"],
    "jump 1 m": ["jump:random::1"],
    "jump 1 rad": ["turn_jump:random::1"],
    "dropout": ["dropout:random:5"],
    "covered": ["covered:random:5:0.8"],
    "people": ["people:random:10:0.5"],
    "kidnap": ["kidnap:random:2:2"],
}
KIDNAPPED_EARLY = ["--fault", "kidnap:25:2:2", "--duration", 60]
MAPPED = 250  # [s] that a lap through rooms takes
BETWEEN = 80  # [s] between kidnappings
CARRIED = 2  # [s]
PER_DRIVE = 5
KIDNAPPED = [part for i in range(PER_DRIVE)
             for part in ("--fault", f"kidnap:{MAPPED + i * BETWEEN}:{CARRIED}:2")]
# So many laps that it does not come to where the route ends, and stands.
KIDNAPPED += ["--laps", 200, "--duration", MAPPED + PER_DRIVE * BETWEEN]
SURE = ("tracking", "recovered")  # states
ELLIPSE = 16.27  # of 99.9 %, three degrees of freedom


@functools.lru_cache(maxsize=None)
def path_of(program):
    """rosrun itself takes longer than a short drive. The folder $MATCHBOX_PROGRAMS goes first."""
    if "MATCHBOX_PROGRAMS" in os.environ:
        return os.path.join(os.environ["MATCHBOX_PROGRAMS"], program)
    found = subprocess.run(["rosrun", "--prefix", "echo", "matchbox_slam", program],
                           capture_output=True, text=True)
    if found.returncode != 0:
        raise SystemExit(f"{program} is not found: source the workspace first; {found.stderr.strip()}")
    return found.stdout.strip()


def output_of(program, *arguments, timeout=None):
    command = [path_of(program), *map(str, arguments)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    except subprocess.TimeoutExpired:
        raise SystemExit(f"{' '.join(command)}: not done after {timeout} s")
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout


def read_tum(path):
    poses = {}
    for line in path.read_text().splitlines():
        if line.startswith("#"):  # of a map that was gone on with
            continue
        t, x, y, _, _, _, qz, qw = map(float, line.split())
        poses[round(t, 6)] = (x, y, 2.0 * math.atan2(qz, qw))
    return poses


def wrapped(angle):
    return math.atan2(math.sin(angle), math.cos(angle))


def composed(a, b):
    c, s = math.cos(a[2]), math.sin(a[2])
    return (a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], wrapped(a[2] + b[2]))


def inverse(a):
    c, s = math.cos(a[2]), math.sin(a[2])
    return (-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2])


def in_map(truth, first):
    """The truth in the frame of the map, which begins where the first scan was taken."""
    map_from_world = inverse(truth[first])
    return {stamp: composed(map_from_world, pose) for stamp, pose in truth.items()}


def aligned(truth, keys):
    """The truth where it fits the map best: where the first scan was taken is known no better than a match."""
    pairs = [(truth[stamp], pose) for stamp, pose in keys.items()]
    (ax, ay), (bx, by) = ([sum(pair[i][k] for pair in pairs) / len(pairs) for k in (0, 1)] for i in (0, 1))
    cross = sum((a[0] - ax) * (b[1] - by) - (a[1] - ay) * (b[0] - bx) for a, b in pairs)
    dot = sum((a[0] - ax) * (b[0] - bx) + (a[1] - ay) * (b[1] - by) for a, b in pairs)
    centre = composed((bx, by, math.atan2(cross, dot)), (-ax, -ay, 0.0))
    return {stamp: composed(centre, pose) for stamp, pose in truth.items()}


def error(pose, true):
    return math.hypot(pose[0] - true[0], pose[1] - true[1]), abs(wrapped(pose[2] - true[2]))


def squared_distance(row, pose, true):
    """Of the error, by the covariance that was told of the scan."""
    d = [pose[0] - true[0], pose[1] - true[1], wrapped(pose[2] - true[2])]
    a, b, c, e, f, i = (float(row["cov_" + k]) for k in ("xx", "xy", "xt", "yy", "yt", "tt"))
    det = a * (e * i - f * f) - b * (b * i - c * f) + c * (b * f - c * e)
    if det <= 0.0:
        return 0.0 if max(map(abs, d)) < 1e-9 else math.inf
    inv = [[e * i - f * f, c * f - b * i, b * f - c * e],
           [c * f - b * i, a * i - c * c, b * c - a * f],
           [b * f - c * e, b * c - a * f, a * e - b * b]]
    return sum(d[j] * inv[j][k] * d[k] for j in range(3) for k in range(3)) / det


def is_wrong(way, turn):
    return way > 0.2 or turn > math.radians(5.0)


def read_scans(folder):
    rows = list(csv.DictReader((folder / "scans.csv").open()))
    return rows, [round(float(row["stamp"]), 6) for row in rows]


def weigh_kidnappings(folder, truth):
    """One row for each, up to the next one."""
    rows, stamps = read_scans(folder)
    true = in_map(truth, stamps[0])
    live = read_tum(folder / "trajectory_live.tum")
    keys = read_tum(folder / "key_scans.tum")
    wrong = [stamp for stamp, pose in keys.items() if is_wrong(*error(pose, true[stamp]))]
    report = json.loads((folder / "report.json").read_text())
    results = []
    for i in range(PER_DRIVE):
        begin = stamps[0] + MAPPED + i * BETWEEN
        scans = [(row, stamp) for row, stamp in zip(rows, stamps) if begin <= stamp < begin + BETWEEN]
        unsure = [stamp for row, stamp in scans if row["state"] not in SURE]
        last, end = scans[-1]
        results.append({
            "end_error_m": error(live[end], true[end])[0], "final_state": last["state"],
            "wrong_keys": sum(begin <= stamp < begin + BETWEEN for stamp in wrong),
            "unsure_s": unsure[-1] - begin if unsure else 0.0,
            "cpu_s": report["cpu_s"] / PER_DRIVE, "scan_ms": report["scan_ms"],
        })
    return results


def weigh(folder, truth):
    rows, stamps = read_scans(folder)
    true = in_map(truth, stamps[0])
    final = read_tum(folder / "trajectory.tum")
    keys = read_tum(folder / "key_scans.tum")
    errors = {stamp: error(pose, true[stamp]) for stamp, pose in keys.items()}
    wrong = [s for s, (way, turn) in errors.items() if is_wrong(way, turn)]
    end_error = error(final[stamps[-1]], true[stamps[-1]])[0]
    accepted = [(r, s) for r, s in zip(rows, stamps) if r["status"] == "accepted"]
    in_place = aligned(truth, keys)
    inside = sum(squared_distance(r, final[s], in_place[s]) <= ELLIPSE for r, s in accepted[1:])
    states = [r["state"] for r in rows]
    unsure = [b - a for a, b, state in zip(stamps, stamps[1:], states) if state not in SURE]
    way = sum(math.hypot(true[a][0] - true[b][0], true[a][1] - true[b][1])
              for a, b in zip(stamps, stamps[1:]))
    entered = collections.Counter(b for a, b in zip(["tracking"] + states, states) if a != b)
    report = json.loads((folder / "report.json").read_text())
    return {
        "end_error_m": end_error,
        "worst_key_m": max(way for way, _ in errors.values()),
        "wrong_keys": len(wrong), "keys": len(keys),
        "inside": inside, "accepted": len(accepted) - 1,
        "doubts": entered["doubt"], "losses": entered["lost"], "final_state": states[-1],
        "unsure_s": sum(unsure),
        "way_m": way, "cpu_s": report["cpu_s"],
        "scan_ms": report["scan_ms"],
    }


def weigh_drive(folder, truth):
    return [weigh(folder, truth)]


def one_run(world, fault, seed, faults, weigh_run, arguments):
    out, matchers = arguments.out, arguments.matchers
    folder = out / f"{world}-{fault.replace(' ', '_')}-{seed}"
    folder.mkdir(parents=True, exist_ok=True)
    bag, truth = folder / "drive.bag", folder / "truth.tum"
    output_of("simulate", "--world", world, "--seed", seed, "--scan-rate", arguments.rate, "--bag", bag,
        "--truth", truth, *faults, *shlex.split(arguments.simulate))
    results = []
    for matcher in matchers:
        sets = sets_of(arguments.overrides)
        output_of("map_bag", bag, "--matcher", matcher, "--out", folder / matcher, "--quiet", *sets)
        results += [{"world": world, "fault": fault, "seed": seed, "matcher": matcher, **row}
                    for row in weigh_run(folder / matcher, read_tum(truth))]
    bag.unlink()
    if fault == "kidnap" and all(map(is_found, results)):
        shutil.rmtree(folder)  # of a thousand
    return results


def table(results):
    groups = collections.defaultdict(list)
    for result in results:
        groups[result["world"], result["fault"], result["matcher"]].append(result)
    lines = ["| world | fault | matcher | runs | end within 5 cm | ends lost | runs with a wrong key scan | "
             "doubts / losses a km | unsure, median [s] | in the 99.9 % ellipse |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    for (world, fault, matcher), runs in groups.items():
        km = sum(r["way_m"] for r in runs) / 1000.0
        unsure = sorted(r["unsure_s"] for r in runs)[len(runs) // 2]
        share = 100.0 * sum(r["inside"] for r in runs) / max(1, sum(r["accepted"] for r in runs))
        lines.append(
            f"| {world} | {fault} | {matcher} | {len(runs)} | "
            f"{sum(r['end_error_m'] <= 0.05 for r in runs)} | "
            f"{sum(r['final_state'] == 'lost' for r in runs)} | "
            f"{sum(r['wrong_keys'] > 0 for r in runs)} | "
            f"{sum(r['doubts'] for r in runs) / km:.1f} / {sum(r['losses'] for r in runs) / km:.1f} | "
            f"{unsure:.1f} | {share:.2f} % |")
    return "\n".join(lines) + "\n"


def is_found(row):
    return row["final_state"] != "lost" and row["end_error_m"] <= 0.05 and not row["wrong_keys"]


def kidnapped_table(results):
    """Found: not lost at the end, and where it is. Falsely found: tracking elsewhere, or a wrong key scan is in the map."""
    lines = ["| matcher | kidnappings | found | falsely found | still lost at the end | unsure, median of those found [s] |",
             "|---|---|---|---|---|---|"]
    for matcher in dict.fromkeys(result["matcher"] for result in results):
        runs = [result for result in results if result["matcher"] == matcher]
        lost = [run for run in runs if run["final_state"] == "lost" and not run["wrong_keys"]]
        found = list(filter(is_found, runs))
        unsure = sorted(run["unsure_s"] for run in found) or [math.nan]
        lines.append(f"| {matcher} | {len(runs)} | {len(found)} | {len(runs) - len(found) - len(lost)} | "
                     f"{len(lost)} | {unsure[len(unsure) // 2]:.1f} |")
    return "\n".join(lines) + "\n"


def write_study(name, results, page, arguments):
    """What a study ends with: its results as NAME.json and its page as NAME.md, which is printed, too."""
    (arguments.out / f"{name}.json").write_text(json.dumps(results, indent=1))
    (arguments.out / f"{name.upper()}.md").write_text(page)
    print(page, end="")


def sets_of(overrides):
    """Options of map_bag, as KEY=VALUE, as its arguments."""
    return [part for text in overrides for part in ("--set", text)]


def share(values, fraction):
    """The value that this fraction of them are less than; None of no values."""
    values = sorted(values)
    return values[min(len(values) - 1, int(fraction * len(values)))] if values else None


def text(value, decimals):
    """Of a number, for a table."""
    return "–" if value is None else f"{value:.{decimals}f}"


def rows_of_seeds(rows_of, arguments):
    """The rows that `rows_of(seed, arguments)` gives for each seed, some seeds at a time."""
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.seeds)
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        return [row for rows in pool.map(lambda seed: rows_of(seed, arguments), seeds) for row in rows]


def study_parser(description, seeds, rate=None):
    """Arguments that studies over simulated drives share."""
    parser = argparse.ArgumentParser(description=description,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--seeds", type=int, default=seeds)
    parser.add_argument("--first-seed", type=int, default=1)
    if rate is not None:
        parser.add_argument("--rate", type=float, default=rate, help="scans a second")
    parser.add_argument("--set", action="append", default=[], dest="overrides")
    parser.add_argument("--jobs", type=int, default=2)
    return parser


def main():
    parser = study_parser(__doc__, seeds=20, rate=10.0)
    parser.add_argument("--worlds", nargs="+", default=["rooms", "random"])
    parser.add_argument("--faults", nargs="+", default=list(FAULTS), choices=list(FAULTS))
    parser.add_argument("--matchers", nargs="+", default=["olson", "hough", "monte_carlo"])
    parser.add_argument("--simulate", default="", help="further options of simulate, such as '--beams 181'")
    kidnappings = parser.add_mutually_exclusive_group()
    kidnappings.add_argument("--kidnappings", type=int, default=0, metavar="N")
    kidnappings.add_argument("--early-kidnappings", type=int, default=0, metavar="N")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.seeds)
    is_kidnapping = arguments.kidnappings or arguments.early_kidnappings
    if arguments.kidnappings:
        tasks = [("rooms", "kidnap", arguments.first_seed + i, KIDNAPPED, weigh_kidnappings)
                 for i in range(-(-arguments.kidnappings // PER_DRIVE))]
    elif arguments.early_kidnappings:
        tasks = [("rooms", "kidnap", arguments.first_seed + i, KIDNAPPED_EARLY, weigh_drive)
                 for i in range(arguments.early_kidnappings)]
    else:
        tasks = [(world, fault, seed, [part for text in FAULTS[fault] for part in ("--fault", text)], weigh_drive)
                 for world in arguments.worlds for fault in arguments.faults for seed in seeds]
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        futures = [pool.submit(one_run, *task, arguments) for task in tasks]
        results = [result for future in futures for result in future.result()]
    write_study("faults", results, (kidnapped_table if is_kidnapping else table)(results), arguments)


if __name__ == "__main__":
    main()
