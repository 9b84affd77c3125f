#!/usr/bin/env python3
"""Drives a simulated robot through the same rooms again and again: what its map costs after one hour, and after many.

One drive a seed; it is mapped up to each of --hours, with and without making room. With the workspace sourced:
run_years.py --out DIR [--seeds 1] [--hours 1 2 6] [--beams 361] [--set section/option=value ...]
Writes DIR/years.json (a row a run) and DIR/YEARS.md.
"""
import json
import math
import statistics

from run_faults import error, in_map, output_of, read_tum, rows_of_seeds, sets_of, study_parser, write_study

LAP = 222.0  # [s] of the way through the rooms
KEPT = {"room is made": [], "all are kept": ["--set", "slam/enough_views=0"]}


def one_run(folder, bag, truth, hours, kept, overrides):
    out = folder / f"{hours:g}h-{kept.replace(' ', '_')}"
    sets = sets_of(overrides)
    output_of("map_bag", bag, "--duration", hours * 3600, "--out", out, "--quiet", *KEPT[kept], *sets)
    report = json.loads((out / "report.json").read_text())
    final = read_tum(out / "trajectory.tum")
    true = in_map(truth, min(final))
    squares = [error(final[stamp], true[stamp])[0] ** 2 for stamp in final]
    last = [error(final[stamp], true[stamp])[0] ** 2 for stamp in sorted(final)[-len(final) // 10:]]
    edges = sum(line.startswith("EDGE") for line in (out / "graph.g2o").open())
    return {"hours": hours, "kept": kept, "key_scans": sum(1 for _ in (out / "key_scans.tum").open()), "edges": edges,
            "map_mb": (out / "map.slam").stat().st_size / 1e6, "p50_ms": report["scan_ms"]["p50"],
            "p99_ms": report["scan_ms"]["p99"], "max_ms": report["scan_ms"]["max"], "cpu_s": report["cpu_s"],
            "rss_mb": report["peak_rss_mb"], "rmse_m": math.sqrt(statistics.mean(squares)),
            "last_rmse_m": math.sqrt(statistics.mean(last))}


def drive(seed, arguments):
    folder = arguments.out / str(seed)
    folder.mkdir(parents=True, exist_ok=True)
    bag, truth = folder / "drive.bag", folder / "truth.tum"
    output_of("simulate", "--world", arguments.world, "--seed", seed, "--beams", arguments.beams, "--scan-rate",
              arguments.rate, "--laps", math.ceil(max(arguments.hours) * 3600 / LAP), "--bag", bag, "--truth", truth)
    true = read_tum(truth)
    rows = []
    for hours in arguments.hours:
        for kept in KEPT:
            rows.append({"seed": seed, **one_run(folder, bag, true, hours, kept, arguments.overrides)})
            print(json.dumps(rows[-1]), flush=True)
    bag.unlink()
    return rows


def table(rows):
    lines = ["| seed | hours | | key scans | edges | `map.slam` [MB] | scan p50 [ms] | p99 | worst | CPU [s] | memory [MB] | "
             "error [m] | of the last tenth |", "|" + "---|" * 13]
    for row in rows:
        lines.append(f"| {row['seed']} | {row['hours']:g} | {row['kept']} | {row['key_scans']} | {row['edges']} | "
                     f"{row['map_mb']:.2f} | {row['p50_ms']:.2f} | {row['p99_ms']:.1f} | {row['max_ms']:.0f} | "
                     f"{row['cpu_s']:.0f} | {row['rss_mb']:.0f} | {row['rmse_m']:.4f} | {row['last_rmse_m']:.4f} |")
    return "\n".join(lines) + "\n"


def main():
    parser = study_parser(__doc__, seeds=1, rate=5.0)
    parser.add_argument("--world", default="rooms")
    parser.add_argument("--hours", nargs="+", type=float, default=[1.0, 2.0, 6.0])
    parser.add_argument("--beams", type=int, default=361)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = rows_of_seeds(drive, arguments)
    write_study("years", rows, table(rows), arguments)


if __name__ == "__main__":
    main()
