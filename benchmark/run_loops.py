#!/usr/bin/env python3
"""Drives simulated robots through worlds with loops, and tells how good the maps are and which loops are wrong.

Worlds x drives x seeds. Each run: `simulate`, then `map_bag`; the truth is known. A closed loop is wrong when where it
says that its two key scans are to each other differs from the truth by more than 0.3 m or 5 degrees.
With the workspace sourced: run_loops.py --out DIR [--seeds 10] [--set section/option=value ...]
Writes DIR/loops.json (a row a run) and DIR/LOOPS.md (a row for each world and drive).
"""
import collections
import concurrent.futures
import json
import math

from run_faults import composed, error, inverse, output_of, read_tum, sets_of, study_parser, write_study

DRIVES = {
    "default": [],
    "10x odometry noise": ["--translation-noise", 0.2, "--rotation-noise", 0.3, "--heading-noise", 0.08],
    "faults": [part for fault in (
        "freeze:random:3", "encoders:random:2", "heading_slip:random:3:-0.8", "way_slip:random:3:-0.9",
        "jump:random::1", "turn_jump:random::1", "dropout:random:5", "covered:random:5:0.8", "people:random:10:0.5")
        for part in ("--fault", fault)],
    "kidnap": ["--fault", "kidnap:random:2:2"],
}


def edges_of(folder):
    """Where the second key scan of an edge is as seen from the first, by the stamps of both."""
    stamps = {}
    for line in (folder / "key_scans.tum").read_text().splitlines():
        stamp, x, y = line.split()[:3]
        stamps[x, y] = round(float(stamp), 6)
    nodes, edges = {}, {}
    for line in (folder / "graph.g2o").read_text().splitlines():
        kind, *row = line.split()
        if kind == "VERTEX_SE2":  # in the order that they came into the map, which may not be that of stamps
            nodes[row[0]] = stamps[f"{float(row[1]):.9f}", f"{float(row[2]):.9f}"]
        elif kind == "EDGE_SE2":
            edges[nodes[row[0]], nodes[row[1]]] = tuple(map(float, row[2:5]))
    return edges


def weigh(folder, loops, truth):
    edges = edges_of(folder)
    errors = []
    for loop in loops["each"]:
        there, here = round(loop["stamp_there"], 6), round(loop["stamp"], 6)
        edge = edges.get((there, here))
        if edge:  # else it is an outlier at the end
            errors.append((*error(edge, composed(inverse(truth[there]), truth[here])), loop))
    wrong = [dict(loop, metres=way, degrees=math.degrees(turn)) for way, turn, loop in errors
             if way > 0.3 or turn > math.radians(5.0)]
    return {"inliers": len(errors), "wrong": wrong, "closed": loops["closed"],
            "refused": loops["refused"], "tried": loops["tried"],
            "worst_loop_m": max((way for way, _, _ in errors), default=0.0)}


def one_run(world, drive, seed, arguments):
    folder = arguments.out / f"{world}-{drive.replace(' ', '_')}-{seed}"
    folder.mkdir(parents=True, exist_ok=True)
    bag, truth = folder / "drive.bag", folder / "truth.tum"
    output_of("simulate", "--world", world, "--seed", seed, "--scan-rate", arguments.rate, "--beams",
              arguments.beams, "--speed", arguments.speed, "--bag", bag, "--truth", truth,
              *DRIVES[drive])
    sets = sets_of(arguments.overrides)
    output_of("map_bag", bag, "--matcher", arguments.matcher, "--out", folder, "--quiet", *sets)
    bag.unlink()
    report = json.loads((folder / "report.json").read_text())
    if report["interrupted"]:
        raise SystemExit(f"{folder}: map_bag was interrupted")
    ate = json.loads(output_of("evaluate", "ate", folder / "trajectory.tum", "--truth", truth, "--json"))
    row = {"world": world, "drive": drive, "seed": seed, "ate_m": ate["estimates"][0]["rmse_m"],
           **weigh(folder, report["loops"], read_tum(truth)), "cpu_s": report["cpu_s"]}
    print(json.dumps(row), flush=True)
    return row


def table(results):
    groups = collections.defaultdict(list)
    for result in results:
        groups[result["world"], result["drive"]].append(result)
    lines = ["| world | drive | seeds | ATE: median, worst [m] | loops tried | closed | refused | wrong | CPU a drive [s] |",
             "|---|---|---|---|---|---|---|---|---|"]
    for (world, drive), rows in groups.items():
        ates = sorted(row["ate_m"] for row in rows)
        tried, closed, refused = (sum(row[key] for row in rows) for key in ("tried", "closed", "refused"))
        wrong = sum(len(row["wrong"]) for row in rows)
        cpu = sum(row["cpu_s"] for row in rows) / len(rows)
        lines.append(f"| {world} | {drive} | {len(rows)} | {ates[len(ates) // 2]:.4f}, {ates[-1]:.4f} | {tried} | "
                     f"{closed} | {refused} | {wrong} | {cpu:.0f} |")
    return "\n".join(lines) + "\n"


def main():
    parser = study_parser(__doc__, seeds=10, rate=5.0)
    parser.add_argument("--worlds", nargs="+", default=["campus", "hotel"])
    parser.add_argument("--drives", nargs="+", default=list(DRIVES), choices=list(DRIVES))
    parser.add_argument("--matcher", default="olson")
    parser.add_argument("--beams", type=int, default=360)
    parser.add_argument("--speed", type=float, default=1.0, help="m/s")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    tasks = [(world, drive, arguments.first_seed + seed) for world in arguments.worlds
             for drive in arguments.drives for seed in range(arguments.seeds)]
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        results = list(pool.map(lambda task: one_run(*task, arguments), tasks))
    write_study("loops", results, table(results), arguments)


if __name__ == "__main__":
    main()
