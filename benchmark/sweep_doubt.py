#!/usr/bin/env python3
"""Halves and doubles each threshold of doubt, tracking and recovery, and tells what becomes of short drives with faults.

Each drive is simulated once and mapped with each value. With the workspace sourced:
sweep_doubt.py --out DIR [--seeds 4] [--options doubt/contradiction ...]
Writes DIR/sweep.json (a row a run) and DIR/SWEEP.md (a row for each value). What DIR/sweep.json has is not run again.
"""
import argparse
import concurrent.futures
import csv
import json
import pathlib
import shutil

from run_faults import output_of, read_tum, weigh

SECTIONS = ("doubt", "tracking", "recovery")
FAULT = 25.0  # [s]
DRIVES = [  # world, fault, duration [s]
    ("rooms", "kidnap:25:2:2", 60),
    ("random", "kidnap:25:2:2", 45),
    ("rooms", "freeze:25:3", 45),
    ("random", "freeze:25:3", 45),
]
LIMITS = {"doubt/look_xy": 2.0, "doubt/look_theta": 3.2}  # what is allowed at most, where it is no share
SHARES = {"doubt/contradiction", "doubt/most_contradiction", "doubt/score_drop", "doubt/least_score",
          "doubt/most_rival", "recovery/least_score", "doubt/least_net"}
WHOLE = {"tracking/confirmations", "recovery/key_scans", "recovery/confirmations", "recovery/far_confirmations"}


def thresholds(table):
    """Options of the sections with their defaults, from the page of parameters."""
    rows = (line.split("|") for line in table.read_text().splitlines() if line.startswith("| `"))
    options = {row[1].strip(" `"): row[2].strip(" `") for row in rows}
    return {name: float(value) for name, value in options.items()
            if name.split("/")[0] in SECTIONS and value not in ("true", "false")}


def values_of(name, default):
    """Half and double; a share above a half goes half of the way to 1 instead."""
    double = 2.0 * default
    if name in SHARES and double >= 1.0:
        double = 0.5 * (1.0 + default)
    values = [0.5 * default, min(double, LIMITS.get(name, double))]
    if name in WHOLE:
        values = [max(1, round(value)) for value in values]
    return [value for value in values if value != default]


def simulate(out, seeds):
    drives = []
    for world, fault, duration in DRIVES:
        for seed in seeds:
            name = f"{world}-{fault.split(':')[0]}-{seed}"
            bag, truth = out / f"{name}.bag", out / f"{name}.tum"
            if not truth.exists():
                output_of("simulate", "--world", world, "--seed", seed, "--scan-rate", 10, "--duration", duration,
                          "--bag", bag, "--truth", truth, "--fault", fault)
            drives.append((world, fault.split(":")[0], seed, bag, truth))
    return drives


def first_doubt(folder):
    """[s] since the first scan; none: infinity."""
    rows = list(csv.DictReader((folder / "scans.csv").open()))
    begin = float(rows[0]["stamp"])
    return min((float(row["stamp"]) - begin for row in rows if row["state"] == "doubt"), default=float("inf"))


def one_run(drive, name, value, out):
    world, fault, seed, bag, truth = drive
    folder = out / f"{bag.stem}-{name.replace('/', '_')}-{value}"
    sets = ["--set", f"{name}={value}"] if name else []
    output_of("map_bag", bag, "--matcher", "olson", "--out", folder, "--quiet", *sets)
    result = {"option": name, "value": value, "world": world, "fault": fault, "seed": seed,
              "first_doubt_s": first_doubt(folder), **weigh(folder, read_tum(truth))}
    shutil.rmtree(folder)
    return result


def row_of(name, value, runs):
    kidnapped = [run for run in runs if run["fault"] == "kidnap" and run["world"] == "rooms"]
    return (f"| {name} | {value:g} | {len(runs)} | {sum(run['end_error_m'] <= 0.05 for run in runs)} | "
            f"{sum(run['wrong_keys'] > 0 for run in runs)} | {sum(run['final_state'] == 'lost' for run in runs)} | "
            f"{sum(run['first_doubt_s'] < FAULT for run in runs)} | {sum(run['doubts'] for run in runs)} | "
            f"{sum(run['losses'] for run in runs)} | {sum(run['unsure_s'] for run in runs):.1f} | "
            f"{sum(run['unsure_s'] for run in kidnapped) / max(1, len(kidnapped)):.1f} |")


def table(results):
    lines = ["| option | value | runs | end within 5 cm | with a wrong key scan | end lost | "
             "in doubt before any fault | doubts | losses | unsure, in all [s] | unsure, kidnapped in rooms, mean [s] |",
             "|" + "---|" * 11]
    groups = {}
    for result in results:
        groups.setdefault((result["option"], result["value"]), []).append(result)
    for (name, value), runs in groups.items():
        lines.append(row_of(name or "as it is", value, runs))
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--options", nargs="+", default=[])
    parser.add_argument("--jobs", type=int, default=1)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    page = pathlib.Path(__file__).resolve().parent.parent / "doc" / "parameters.md"
    drives = simulate(arguments.out, range(arguments.first_seed, arguments.first_seed + arguments.seeds))
    tasks = [(drive, "", 0.0) for drive in drives]
    for name, default in thresholds(page).items():
        if arguments.options and name not in arguments.options:
            continue
        # Only a robot that is lost is searched for.
        concerned = [d for d in drives if not name.startswith("recovery/") or d[:2] == ("rooms", "kidnap")]
        tasks += [(drive, name, value) for value in values_of(name, default) for drive in concerned]
    known = arguments.out / "sweep.json"
    results = json.loads(known.read_text()) if known.exists() else []
    done = {(r["world"], r["fault"], r["seed"], r["option"], r["value"]) for r in results}
    tasks = [task for task in tasks if (*task[0][:3], *task[1:]) not in done]
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for future in [pool.submit(one_run, *task, arguments.out) for task in tasks]:
            results.append(future.result())
            known.write_text(json.dumps(results, indent=1))
    (arguments.out / "SWEEP.md").write_text(table(results))
    print(table(results), end="")


if __name__ == "__main__":
    main()
