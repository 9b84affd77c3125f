#!/usr/bin/env python3
"""Lets several robots drive through one world, a part of the way each, and merges their maps.

Each robot has noise of its own, and drives on into the next one's part; one more drives all of the way. Each pair of
worlds of other seeds is merged, too: two buildings, which have to stay apart. With --data, a folder that has intel.bag,
that log is cut in as many parts by time, without overlap, and csail, aces and belgioioso in two that
share a third. Each is merged in the order of the parts and back to front.
With the workspace sourced: run_merging.py --out DIR [--worlds rooms] [--seeds 2] [--set section/option=value ...]
Writes DIR/merging.json (a row a merged map) and DIR/MERGING.md.
"""
import json
import pathlib

from run_faults import error, output_of, read_tum, sets_of, study_parser, write_study

INTEL = 2680.0  # [s] that the log takes
SHARING = {"csail": (270.0, 136.0), "aces": (910.0, 455.0), "belgioioso": (3.6, 1.8)}  # [s] the first ends, the second begins


def map_part(bag, start, duration, out, arguments):
    sets = sets_of(arguments.overrides)
    output_of("map_bag", bag, "--start", max(0.0, start), "--duration", duration, "--out", out, "--quiet", *sets)
    return out / "map.slam"


def merged(maps, out):
    """How many maps they become, and the CPU that it takes; all trajectories are out/all.tum."""
    output_of("merge_maps", *maps, "--out", out, "--quiet")
    report = json.loads((out / "report.json").read_text())
    lines = [line for path in sorted(out.glob("trajectory_*.tum")) for line in path.read_text().splitlines()
             if not line.startswith("#")]
    (out / "all.tum").write_text("\n".join(sorted(lines, key=lambda line: float(line.split()[0]))) + "\n")
    return {"maps": len(report["maps"]), "cpu_s": report["cpu_s"],
            "joints": [joint for one in report["maps"] for joint in one["joints"]]}


def wrong_joints(joints, truth):
    """Where the two key scans that met are farther from each other than anybody could see."""
    return sum(error(truth[round(joint["stamp"], 6)], truth[round(joint["stamp_there"], 6)])[0] > 5.0 for joint in joints)


def ate(trajectory, truth):
    return json.loads(output_of("evaluate", "ate", trajectory, "--truth", truth, "--json"))["estimates"][0]["rmse_m"]


def simulated(world, seed, arguments):
    folder = arguments.out / f"{world}-{seed}"
    folder.mkdir(parents=True, exist_ok=True)
    bags, truths = [], []
    for robot in range(arguments.robots):
        bags.append(folder / f"{robot}.bag")
        truths.append(folder / f"{robot}.tum")
        output_of("simulate", "--world", world, "--seed", seed, "--noise-seed", 100 * seed + robot, "--start-stamp",
                  1327500000 + 10000 * robot, "--scan-rate", arguments.rate, "--beams", arguments.beams, "--speed",
                  arguments.speed, "--bag", bags[-1], "--truth", truths[-1])
    truth = folder / "truth.tum"
    truth.write_text("".join(path.read_text() for path in truths))
    stamps = sorted(read_tum(truths[0]))
    share = (stamps[-1] - stamps[0]) / arguments.robots
    map_part(bags[0], 0.0, 1e6, folder / "one", arguments)
    maps = [map_part(bag, robot * share - arguments.overlap, share + (2.0 if robot > 0 else 1.0) * arguments.overlap,
                     folder / f"robot-{robot}", arguments) for robot, bag in enumerate(bags)]
    for bag in bags:
        bag.unlink()
    one = ate(folder / "one" / "trajectory.tum", truth)
    rows = []
    for order, some in orders(maps):
        result = merged(some, folder / order)
        rows.append({"what": f"{world} {seed}", "order": order, "of": len(some), "one": one,
                     "error": ate(folder / order / "all.tum", truth),
                     "wrong": wrong_joints(result.pop("joints"), read_tum(truth)), **result})
        print(json.dumps(rows[-1]), flush=True)
    return rows, maps[0]


def orders(maps):
    return ("in order", maps), ("back to front", maps[::-1])


def apart(first, second, maps, arguments):
    result = merged(maps, arguments.out / f"{first}-{second}".replace(" ", "_"))
    joints = result.pop("joints")
    row = {"what": f"{first} and {second}", "order": "two buildings", "of": len(maps), "one": None, "error": None,
           "wrong": len(joints), **result}
    print(json.dumps(row), flush=True)
    return row


def relations_error(trajectory, data):
    table = json.loads(output_of("evaluate", "relations", trajectory, "--relations", data / "intel.relations", "--odometry",
                                 data / "intel.odom.tum", "--json"))
    return table["estimates"][0]["translation_m"]["mean"]


def intel(data, arguments):
    folder = arguments.out / "intel"
    share = INTEL / arguments.robots
    map_part(data / "intel.bag", 0.0, 1e6, folder / "one", arguments)
    one = relations_error(folder / "one" / "key_scans.tum", data)
    final = read_tum(folder / "one" / "key_scans.tum")
    maps = [map_part(data / "intel.bag", part * share, share, folder / f"part-{part}", arguments)
            for part in range(arguments.robots)]
    rows = []
    for order, some in orders(maps):
        result = merged(some, folder / order)
        joints = [joint for joint in result.pop("joints")
                  if round(joint["stamp"], 6) in final and round(joint["stamp_there"], 6) in final]
        rows.append({"what": "intel", "order": order, "of": len(some), "one": one,
                     "error": relations_error(folder / order / "all.tum", data), "wrong": wrong_joints(joints, final), **result})
        print(json.dumps(rows[-1]), flush=True)
    return rows


def sharing(name, data, arguments):
    """Two parts of a log that share a third of it, as every key scan there is in both maps."""
    folder = arguments.out / name
    end, begin = SHARING[name]
    map_part(data / f"{name}.bag", 0.0, 1e6, folder / "one", arguments)
    final = read_tum(folder / "one" / "trajectory.tum")
    maps = [map_part(data / f"{name}.bag", 0.0, end, folder / "part-0", arguments),
            map_part(data / f"{name}.bag", begin, 1e6, folder / "part-1", arguments)]
    rows = []
    for order, some in orders(maps):
        result = merged(some, folder / order)
        rows.append({"what": f"{name}, halves that share a third", "order": order, "of": len(some), "one": None, "error": None,
                     "wrong": wrong_joints(result.pop("joints"), final), **result})
        print(json.dumps(rows[-1]), flush=True)
    return rows


def table(rows):
    def metres(value):
        return "" if value is None else f"{value:.4f}"

    lines = ["| drives | order | maps: given, left | one robot that drove it all [m] | merged [m] | ratio | wrong joints | CPU [s] |",
             "|" + "---|" * 8]
    for row in rows:
        ratio = "" if row["one"] is None else f"{row['error'] / row['one']:.2f}"
        lines.append(f"| {row['what']} | {row['order']} | {row['of']}, {row['maps']} | {metres(row['one'])} | "
                     f"{metres(row['error'])} | {ratio} | {row['wrong']} | {row['cpu_s']:.0f} |")
    return "\n".join(lines) + "\n"


def main():
    parser = study_parser(__doc__, seeds=2, rate=5.0)
    parser.add_argument("--worlds", nargs="+", default=["rooms"])
    parser.add_argument("--robots", type=int, default=4)
    parser.add_argument("--overlap", type=float, default=30.0, help="that a robot drives into the part of another, s")
    parser.add_argument("--beams", type=int, default=360)
    parser.add_argument("--speed", type=float, default=0.5, help="m/s")
    parser.add_argument("--data", type=pathlib.Path, help="folder of intel.bag, intel.relations and intel.odom.tum")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows, firsts = [], {}
    for world in arguments.worlds:
        for seed in range(arguments.first_seed, arguments.first_seed + arguments.seeds):
            some, firsts[f"{world} {seed}"] = simulated(world, seed, arguments)
            rows += some
    names = list(firsts)
    for first, second in zip(names, names[1:]):
        rows.append(apart(first, second, [firsts[first], firsts[second]], arguments))
    if arguments.data:
        rows += intel(arguments.data, arguments)
        for name in SHARING:
            rows += sharing(name, arguments.data, arguments)
    write_study("merging", rows, table(rows), arguments)


if __name__ == "__main__":
    main()
