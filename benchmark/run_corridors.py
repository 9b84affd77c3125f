#!/usr/bin/env python3
"""Drives simulated robots with few and many beams through corridors, where odometry has to tell what lasers cannot.

Four minutes each, without faults: the truth is known. With the workspace sourced:
run_corridors.py --out DIR [--seeds 1] [--set section/option=value ...]
Writes DIR/corridors.json (a row a run) and DIR/CORRIDORS.md.
"""
import collections
import concurrent.futures
import json
import math
import statistics

from run_faults import error, in_map, output_of, read_tum, sets_of, study_parser, write_study

# world, beams, reach [m], scans a second, speed [m/s], field of view [rad]
DRIVES = [
    ("hotel", 541, 6, 5, 1.0, 4.54), ("hotel", 541, 10, 10, 1.0, 4.54), ("hotel", 1040, 6, 20, 0.5, 4.54),
    ("hotel", 361, 10, 10, 0.5, 3.14), ("hotel", 181, 15, 10, 0.5, 3.14), ("hotel", 181, 8, 10, 0.6, 3.14),
    ("campus", 541, 6, 10, 1.0, 4.54), ("campus", 541, 10, 10, 1.0, 4.54), ("campus", 361, 10, 5, 0.5, 6.28),
    ("campus", 1040, 30, 20, 0.5, 4.54), ("campus", 541, 15, 10, 0.5, 3.14), ("campus", 181, 10, 10, 0.3, 3.14),
    ("campus", 181, 30, 20, 0.5, 3.14), ("campus", 181, 15, 10, 0.5, 3.14), ("campus", 181, 10, 10, 1.0, 4.54),
    ("loop", 541, 6, 10, 1.0, 4.54),
]


def one_run(number, seed, arguments):
    world, beams, reach, rate, speed, view = DRIVES[number]
    folder = arguments.out / f"{number}-{seed}"
    folder.mkdir(parents=True, exist_ok=True)
    bag, truth = folder / "drive.bag", folder / "truth.tum"
    output_of("simulate", "--world", world, "--seed", 100 * seed + number, "--beams", beams, "--range-max", reach,
              "--scan-rate", rate, "--speed", speed, "--field-of-view", view, "--duration", 240, "--bag", bag,
              "--truth", truth)
    sets = sets_of(arguments.overrides)
    results = []
    for matcher in arguments.matchers:
        output_of("map_bag", bag, "--matcher", matcher, "--out", folder / matcher, "--quiet", *sets)
        final = read_tum(folder / matcher / "trajectory.tum")
        true = in_map(read_tum(truth), min(final))
        squares = [error(final[stamp], true[stamp])[0] ** 2 for stamp in final]
        report = json.loads((folder / matcher / "report.json").read_text())
        results.append({"world": world, "beams": beams, "reach_m": reach, "seed": seed, "matcher": matcher,
                        "rmse_m": math.sqrt(statistics.mean(squares)), "cpu_s": report["cpu_s"]})
    bag.unlink()
    return results


def table(results):
    groups = collections.defaultdict(list)
    for result in results:
        laser = "up to 361 beams" if result["beams"] <= 361 else "more"
        groups[result["matcher"], result["world"], laser].append(result)
        groups[result["matcher"], "all", ""].append(result)
    lines = ["| matcher | world | laser | drives | mean error [m] | median | worst | CPU [s] |",
             "|---|---|---|---|---|---|---|---|"]
    for (matcher, world, laser), runs in sorted(groups.items()):
        errors = [run["rmse_m"] for run in runs]
        lines.append(f"| {matcher} | {world} | {laser} | {len(runs)} | {statistics.mean(errors):.3f} | "
                     f"{statistics.median(errors):.3f} | {max(errors):.3f} | {sum(run['cpu_s'] for run in runs):.1f} |")
    return "\n".join(lines) + "\n"


def main():
    parser = study_parser(__doc__, seeds=1)
    parser.add_argument("--matchers", nargs="+", default=["olson"])
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    tasks = [(number, arguments.first_seed + seed) for seed in range(arguments.seeds) for number in range(len(DRIVES))]
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        futures = [pool.submit(one_run, *task, arguments) for task in tasks]
        results = [result for future in futures for result in future.result()]
    write_study("corridors", results, table(results), arguments)


if __name__ == "__main__":
    main()
