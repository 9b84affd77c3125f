#!/usr/bin/env python3
"""Localises simulated robots in maps of the same rooms: how far off, and how soon found when nobody says where they are.

A drive by --map-sensor is mapped; other drives, at another speed, are localised in its map.slam and in its map.yaml
(map_server's) with slam/update_map=false. With the workspace sourced:
run_localising.py --out DIR [--seeds 5] [--starts 20] [--sensors utm30 ...] [--set section/option=value ...]
Of each seed, sensor and map: one drive that is told where it begins, and --starts pieces of it that are not.
Writes DIR/localising.json and DIR/LOCALISING.md.
"""
import json
import math
import statistics

from run_faults import (SURE, aligned, composed, error, inverse, is_wrong, output_of, read_scans, read_tum, rows_of_seeds,
                        sets_of, share, study_parser, text, write_study)
from zoo_drives import SWEEPS

PIECE = 40.0  # [s] of a drive that nobody says where it begins
JUMP = 0.02  # [m] of map -> odom, at the base, from scan to scan
MAPS = {"slam": "map.slam", "image": "map.yaml"}


def localise(bag, out, map_file, overrides, *options):
    sets = sets_of(["slam/update_map=false", *overrides])
    output_of("map_bag", bag, "--map", map_file, "--out", out, "--quiet", *sets, *options)
    rows, stamps = read_scans(out)
    return rows, stamps, read_tum(out / "trajectory_live.tum")


def jumps_of(stamps, sure, live, odometry):
    """How often and how far the base jumps in the map against what odometry says of its motion."""
    jumps = []
    for a, b in zip(stamps, stamps[1:]):
        if a in sure and b in sure and a in odometry and b in odometry:
            by_odometry = composed(live[a], composed(inverse(odometry[a]), odometry[b]))
            jumps.append(math.hypot(by_odometry[0] - live[b][0], by_odometry[1] - live[b][1]))
    return jumps


def weigh_told(rows, stamps, live, true, odometry):
    sure = {stamp for row, stamp in zip(rows, stamps) if row["state"] in SURE}
    errors = [error(live[stamp], true[stamp]) for stamp in stamps if stamp in sure]
    jumps = jumps_of(stamps, sure, live, odometry)
    return {"scans": len(stamps), "sure": len(sure), "wrong": sum(is_wrong(*one) for one in errors),
            "m": [share([way for way, _ in errors], f) for f in (0.5, 0.95, 1.0)],
            "deg": [share([math.degrees(turn) for _, turn in errors], f) for f in (0.5, 0.95, 1.0)],
            "jumps": sum(jump > JUMP for jump in jumps), "worst_jump_m": max(jumps, default=0.0)}


def weigh_start(rows, stamps, live, true):
    states = [row["state"] for row in rows]
    found = next((i for i, state in enumerate(states) if state in SURE), None)
    wrong = sum(state in SURE and is_wrong(*error(live[stamp], true[stamp])) for state, stamp in zip(states, stamps))
    way = None if found is None else sum(
        math.hypot(true[a][0] - true[b][0], true[a][1] - true[b][1]) for a, b in zip(stamps[:found], stamps[1:found + 1]))
    return {"found_s": None if found is None else stamps[found] - stamps[0], "found_m": way, "wrong": wrong,
            "lost_again": found is not None and any(state == "lost" for state in states[found:])}


def one_sensor(seed, sensor, map_folder, to_map, arguments):
    """The localised drives of a seed by one sensor."""
    folder = arguments.out / str(seed) / sensor
    folder.mkdir(parents=True, exist_ok=True)
    bag, truth_file = folder / "drive.bag", folder / "truth.tum"
    output_of("simulate", "--world", arguments.world, "--seed", seed, "--sensor", sensor, "--speed", 0.4,
              "--scan-rate", SWEEPS.get(sensor, arguments.rate), "--bag", bag, "--truth", truth_file,
              *arguments.simulate.split())
    true = {stamp: composed(to_map, pose) for stamp, pose in read_tum(truth_file).items()}
    stamps = sorted(true)
    rows = []
    for name in arguments.maps:
        map_file = MAPS[name]
        kind = {"seed": seed, "sensor": sensor, "map": name}
        pose = ",".join(f"{value:.6f}" for value in true[stamps[0]])
        out = folder / name
        told = localise(bag, out, map_folder / map_file, arguments.overrides, f"--pose={pose}")
        rows.append({**kind, "told": True, **weigh_told(*told, true, read_tum(out / "odometry.tum"))})
        for i in range(arguments.starts):
            begin = (i + 0.5) / arguments.starts * (stamps[-1] - stamps[0] - PIECE)
            piece = localise(bag, out, map_folder / map_file, arguments.overrides, "--start", begin, "--duration", PIECE)
            rows.append({**kind, "told": False, "begin": begin, **weigh_start(*piece, true)})
        print(json.dumps(rows[-1 - arguments.starts]), flush=True)
    bag.unlink()
    return rows


def one_seed(seed, arguments):
    folder = arguments.out / str(seed)
    folder.mkdir(parents=True, exist_ok=True)
    bag, truth_file = folder / "mapped.bag", folder / "mapped.tum"
    output_of("simulate", "--world", arguments.world, "--seed", seed, "--sensor", arguments.map_sensor, "--scan-rate",
              arguments.rate, "--bag", bag, "--truth", truth_file)
    output_of("map_bag", bag, "--out", folder / "map", "--quiet")
    bag.unlink()
    truth = read_tum(truth_file)
    stamp, pose = next(iter(aligned(truth, read_tum(folder / "map" / "key_scans.tum")).items()))
    to_map = composed(pose, inverse(truth[stamp]))
    return [row for sensor in arguments.sensors for row in one_sensor(seed, sensor, folder / "map", to_map, arguments)]


def line_of(rows):
    told = [row for row in rows if row["told"]]
    starts = [row for row in rows if not row["told"]]
    found = [row for row in starts if row["found_s"] is not None]
    worst = [max(row[key][i] or 0.0 for row in told) for key, i in (("m", 1), ("deg", 1))]
    medians = [statistics.median(row[key][0] or 0.0 for row in told) for key in ("m", "deg")]
    cells = [text(medians[0], 4), text(worst[0], 4), text(medians[1], 3), text(worst[1], 3),
             f"{100.0 * sum(row['sure'] for row in told) / sum(row['scans'] for row in told):.1f} %",
             sum(row["wrong"] for row in told), sum(row["jumps"] for row in told),
             text(max(row["worst_jump_m"] for row in told), 3), f"{len(found)} of {len(starts)}",
             text(share([row["found_s"] for row in found], 0.5), 1), text(share([row["found_s"] for row in found], 0.95), 1),
             text(share([row["found_m"] for row in found], 0.95), 1), sum(row["wrong"] > 0 for row in starts)]
    return " | ".join(map(str, cells))


def table(rows):
    lines = ["| sensor | map | median [m] | p95 of the worst drive | median [deg] | p95 | sure | scans sure and wrong | "
             "jumps above 2 cm | worst jump [m] | found | after, median [s] | p95 [s] | p95 of the way [m] | starts wrong |",
             "|" + "---|" * 15]
    for sensor in dict.fromkeys(row["sensor"] for row in rows):
        for name in MAPS:
            some = [row for row in rows if (row["sensor"], row["map"]) == (sensor, name)]
            if some:
                lines.append(f"| {sensor} | {name} | {line_of(some)} |")
    return "\n".join(lines) + "\n"


def main():
    parser = study_parser(__doc__, seeds=5, rate=10.0)
    parser.add_argument("--world", default="rooms")
    parser.add_argument("--map-sensor", default="utm30")
    parser.add_argument("--sensors", nargs="+", default=["utm30", "lds01", "narrow120", "depth_camera"])
    parser.add_argument("--starts", type=int, default=20)
    parser.add_argument("--maps", nargs="+", default=list(MAPS), choices=list(MAPS))
    parser.add_argument("--simulate", default="",
                        help="further options of simulate for the localised drives, such as '--moved 0.5'")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = rows_of_seeds(one_seed, arguments)
    write_study("localising", rows, table(rows), arguments)


if __name__ == "__main__":
    main()
