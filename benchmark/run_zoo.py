#!/usr/bin/env python3
"""The zoo: drives of every kind, mapped with the default, with each mechanism left out, and with each alone.

Simulated worlds x sensors x odometry x distances between scans x faults, so that all pairs of them occur (zoo_drives.py), and
the recordings of --data: whole, with every second and fourth scan or beam, and with the reach cut to 8 m. With the
workspace sourced, or with --bin:

    run_zoo.py --out DIR                      # within an hour on two cores
    run_zoo.py --out DIR --no-mechanisms      # the default alone
    run_zoo.py --out DIR --quick              # a dozen drives by the default alone, within a minute
    run_zoo.py --out DIR --compare OLD.json   # ... and what changed since
    run_zoo.py --out DIR --others 1           # none of these, and no recording: to judge on
    run_zoo.py --out DIR --unseen             # likewise, in worlds that the zoo does not have

Writes DIR/ZOO.md and DIR/zoo.json. What was run before by the same programs is not run again: DIR keeps the simulated bags
and a line for each run. With --from ZOO.json nothing is run: tables, page and comparison are made of that file.
"""
import argparse
import concurrent.futures
import datetime
import hashlib
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import threading
import time

import report
import zoo_report
from run_bags import RECORDINGS
from run_faults import SURE, output_of, path_of, read_scans, sets_of
from zoo_drives import UNSEEN_WORLDS, WORLDS, all_drives, quick_drives, unseen_drives

# What switches each off, by options of map_bag. Those that it does not know are told and left out of the run.
MECHANISMS = {
    "loops": ["slam/loop_closing=false"],
    "hypotheses": ["hypotheses/enabled=false"],
    "calibrate": ["motion/calibrate=false"],
    "share": ["motion/min_noise_scale=1"],
    "straighten": ["scan/straighten_walls=false"],
    "clear": ["map/no_return_quality=0"],  # of the map, by beams without return
}

# What is left of a recording: every so many scans, every so many beams, options of map_bag.
THINNINGS = {
    "whole": (1, 1, []),
    "every 2nd scan": (2, 1, []),
    "every 4th scan": (4, 1, []),
    "every 2nd beam": (1, 2, []),
    "every 4th beam": (1, 4, []),
    "reach 8 m": (1, 1, ["--set", "scan/max_range=8"]),
}

NEVER_ALONE = ("every 2nd scan", "every 2nd beam")  # for the time: mechanisms are left out of these, but not tried alone

# [m] Errors below what a truth is good for count as equal. Those of poses that came with a log, made by a particle filter (5 to 40 cm,
# more where the log is longer), are guesses, as is what odometry adds to relations between scans of intel.
FLOORS = {"jarvis_circular": 0.004, "intel": 0.05, "aces": 0.1, "belgioioso": 0.08, "csail": 0.1, "seattle": 0.05, "acapulco": 0.2,
          "infinite_corridor": 0.4}
LONGEST = 600  # [s] of one program; a run that takes longer has failed
HERE = os.path.dirname(os.path.abspath(__file__))
PYTHON = "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else sys.executable  # pyenv's and conda's have no rosbag
FOLDED = re.compile(r"\s+")


def use_space(folder):
    """The programs of a devel space, in place of those that are sourced."""
    setup = folder / "setup.bash"
    if setup.exists():
        done = subprocess.run(["bash", "-c", f"source {shlex.quote(str(setup))} && env -0"], capture_output=True, text=True)
        os.environ.update(line.split("=", 1) for line in done.stdout.split("\0") if "=" in line)
    programs = folder / "lib" / "matchbox_slam"
    if not (programs / "map_bag").exists():
        raise SystemExit(f"--bin: there is no map_bag in {programs}")
    os.environ["MATCHBOX_PROGRAMS"] = str(programs)


def digest_of(program, plugins):
    """Of a program's bytes, and of the package's libraries that it links or loads."""
    path = pathlib.Path(path_of(program)).resolve()
    files = set(path.parent.parent.glob("libmatchbox_slam*.so")) if plugins else set()
    linked = subprocess.run(["ldd", path], capture_output=True, text=True).stdout
    files |= {pathlib.Path(name) for name in re.findall(r"=> (\S*libmatchbox_slam\S*)", linked)}
    digest = hashlib.sha256()
    for file in [path, *sorted(files)]:
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def configurations(mechanisms):
    """Options of each, by name."""
    sets = {"default": []}
    if mechanisms:
        sets["none"] = [one for off in mechanisms.values() for one in off]
    for name, off in mechanisms.items():
        sets["-" + name] = off
    for name in mechanisms:
        sets["+" + name] = [one for other, off in mechanisms.items() if other != name for one in off]
    return {name: sets_of(ones) for name, ones in sets.items()}


class Simulated:
    """A drive whose bag is made once."""

    def __init__(self, drive, space):
        self.name, self.kinds, self.floor, self.has_truth, self.each_alone = drive.name, drive.kinds, 0.0, True, True
        self.map_options, self.options = drive.map_options(), drive.simulate_options()
        key = hashlib.sha256(" ".join([space.simulator, *self.options]).encode()).hexdigest()[:8]
        self.bag = space.bags / f"{self.name}-{key}.bag"
        self.truth = self.bag.with_suffix(".tum")
        self.input = key
        self.commands = ["simulate " + " ".join(self.options) + " --bag drive.bag --truth truth.tum",
                         shlex.join(["map_bag", "drive.bag", *self.map_options, "--out", "out"])]

    def prepare(self):
        if not self.bag.exists():
            aside = self.bag.with_suffix(".part")
            output_of("simulate", *self.options, "--bag", aside, "--truth", self.truth, timeout=LONGEST)
            aside.rename(self.bag)

    def errors_of(self, folder):
        return ate_of(folder, self.truth)


class Recording:
    """A recording, or what is left of it."""

    def __init__(self, recording, thinning, space):
        name, file, options, truth = recording
        scans, beams, more = THINNINGS[thinning]
        self.name = f"{name} {thinning}".replace(", ", "-").replace(" ", "_")
        self.kinds = {"recording": name, "thinning": thinning}
        self.each_alone = thinning not in NEVER_ALONE
        self.source = (space.data / f"{file}.bag").resolve()
        is_thin = scans * beams > 1
        self.bag = space.bags / f"{self.name}.bag" if is_thin else self.source
        self.floor, self.has_truth = FLOORS.get(file, 0.0), truth is not None
        self.metric = truth and [str(space.data / word) if "." in word else word for word in truth]
        self.map_options = options + more
        state = self.source.stat()
        self.input = f"{state.st_size}-{int(state.st_mtime)}-{self.metric}"
        topic = ["--scan", options[options.index("--scan-topic") + 1]] if "--scan-topic" in options else []
        self.thinning = [*topic, "--scans", str(scans), "--beams", str(beams)]
        self.commands = []
        if is_thin:
            self.commands.append(shlex.join(["benchmark/thin_bag.py", f"{file}.bag", "drive.bag", *self.thinning]))
        self.commands.append(shlex.join(["map_bag", "drive.bag" if is_thin else f"{file}.bag", *self.map_options, "--out", "out"]))

    def prepare(self):
        if self.bag != self.source and not (self.bag.exists() and self.bag.stat().st_mtime >= self.source.stat().st_mtime):
            done = subprocess.run([PYTHON, os.path.join(HERE, "thin_bag.py"), self.source, self.bag, *self.thinning],
                                  capture_output=True, text=True)
            if done.returncode != 0:
                raise SystemExit(done.stderr.strip())

    def errors_of(self, folder):
        if not self.has_truth:
            return {}
        if self.metric[0] == "ate":
            return ate_of(folder, self.metric[2])
        done = output_of("evaluate", self.metric[0], folder / "trajectory.tum", "--json", *self.metric[1:], timeout=LONGEST)
        return {"ate_m": json.loads(done)["estimates"][0]["translation_m"]["mean"]}


def ate_of(folder, truth):
    estimates = [folder / name for name in ("trajectory.tum", "odometry.tum")]
    estimates = [path for path in estimates if path.exists() and path.stat().st_size > 0]
    done = json.loads(output_of("evaluate", "ate", *estimates, "--truth", truth, "--json", timeout=LONGEST))
    errors = {pathlib.Path(one["estimate"]).stem: one["rmse_m"] for one in done["estimates"]}
    return {"ate_m": errors["trajectory"], "odometry_m": errors.get("odometry")}


class Space:
    """Where things lie, and what was run before."""

    def __init__(self, arguments):
        self.out, self.data, self.bags = arguments.out, arguments.data, arguments.out / "bags"
        self.bags.mkdir(parents=True, exist_ok=True)
        self.simulator, self.mapper = digest_of("simulate", plugins=False), digest_of("map_bag", plugins=True)
        self.extra = sets_of(arguments.overrides)
        self.file = self.out / "runs.jsonl"
        self.done = {}
        self.lock = threading.Lock()
        self.locks = {}
        for line in self.file.read_text().splitlines() if self.file.exists() else []:
            try:
                key, _, _, run = json.loads(line)
                self.done[key] = run
            except ValueError:  # the last line of a run that was killed
                pass

    def key_of(self, drive, options):
        """All that a run's result hangs on."""
        words = [self.mapper, drive.name, drive.input, *drive.map_options, *options, *self.extra]
        return hashlib.sha256(" ".join(words).encode()).hexdigest()[:16]

    def lock_of(self, drive):
        with self.lock:
            return self.locks.setdefault(drive.name, threading.Lock())

    def keep(self, key, drive, name, run):
        with self.lock:
            self.done[key] = run
            with self.file.open("a") as file:
                file.write(json.dumps([key, drive.name, name, run]) + "\n")


def measure(drive, folder):
    rows, _ = read_scans(folder)
    facts = json.loads((folder / "report.json").read_text())
    count = max(1, len(rows))
    return {**drive.errors_of(folder), "scans": len(rows), "cpu_ms": round(1e3 * facts["cpu_s"] / count, 3),
            "lost": sum(row["state"] == "lost" for row in rows) / count,
            "unsure": sum(row["state"] not in SURE for row in rows) / count, "commit": facts.get("commit", "unknown")}


def one_run(drive, name, options, space):
    """A row; what went wrong with it, if anything did, in `failed`."""
    folder = space.out / "runs" / f"{drive.name}{name}"
    try:
        with space.lock_of(drive):
            drive.prepare()
        output_of("map_bag", drive.bag, *drive.map_options, *options, *space.extra, "--out", folder, "--quiet", timeout=LONGEST)
        run = measure(drive, folder)
        run = {key: round(value, 6) if isinstance(value, float) else value for key, value in run.items()}
    except (SystemExit, Exception) as mistake:  # one run of thousands: the others go on, and the report names it
        run = {"failed": FOLDED.sub(" ", str(mistake).replace(str(space.out), "OUT"))[-300:]}
    shutil.rmtree(folder, ignore_errors=True)
    space.keep(space.key_of(drive, options), drive, name, run)


def known_mechanisms(mechanisms, space):
    """Without those whose options the program refuses, which is told once."""
    bag, truth = space.out / "probe.bag", space.out / "probe.tum"
    output_of("simulate", "--world", "rooms", "--seed", 1, "--duration", 1, "--bag", bag, "--truth", truth)
    known = {}
    for name, off in mechanisms.items():
        sets = sets_of(off)
        try:
            output_of("map_bag", bag, "--out", space.out / "probe", "--quiet", *sets, timeout=LONGEST)
            known[name] = off
        except SystemExit as mistake:
            print(f"{name} is left out: {str(mistake).splitlines()[-1].split(': ', 1)[-1]}", file=sys.stderr)
    shutil.rmtree(space.out / "probe", ignore_errors=True)
    bag.unlink()
    truth.unlink()
    return known


class Progress:
    """On a terminal one line, else one in a while."""

    def __init__(self, total):
        self.total, self.done, self.begin, self.told = total, 0, time.monotonic(), 0.0
        self.is_terminal = sys.stderr.isatty()

    def step(self, text):
        self.done += 1
        now = time.monotonic()
        left = (now - self.begin) / self.done * (self.total - self.done) / 60.0
        line = f"{self.done} of {self.total} runs, some {left:.0f} min left: {text}"
        if self.is_terminal:
            print(f"\r\033[K{line[:100]}", end="\n" if self.done == self.total else "", file=sys.stderr, flush=True)
        elif now - self.told > 30.0:
            self.told = now
            print(line, file=sys.stderr, flush=True)


def recordings_in(data, space):
    found, absent = [], []
    for recording in RECORDINGS:
        if (data / f"{recording[1]}.bag").exists():
            found += [Recording(recording, thinning, space) for thinning in THINNINGS]
        else:
            absent.append(recording[0])
    if absent:
        print(f"not in {data}, and left out: {', '.join(absent)}", file=sys.stderr)
    return found


def drives_of(arguments):
    return (unseen_drives if arguments.unseen else all_drives)(arguments.others)


def chosen(arguments, space):
    drives = drives_of(arguments)
    if arguments.quick:
        drives = quick_drives(drives)
    drives = [Simulated(drive, space) for drive in drives
              if drive.kinds["world"] not in arguments.leave_out and (
                  not arguments.only_world or drive.kinds["world"] in arguments.only_world)]
    if not (arguments.quick or arguments.no_recordings or arguments.only_world or arguments.unseen
            or arguments.others is not None):
        drives += recordings_in(arguments.data, space)
    return [drive for drive in drives if re.search(arguments.only, drive.name)]


def run_all(drives, sets, space, jobs):
    """All defaults first: who stops it early has one table that is whole. False when it was stopped."""
    tasks = [(drive, name, options) for name, options in sets.items() for drive in drives
             if drive.each_alone or not name.startswith("+")]
    tasks = [task for task in tasks if "failed" in space.done.get(space.key_of(task[0], task[2]), {"failed": "not run"})]
    progress = Progress(len(tasks))
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        futures = {pool.submit(one_run, *task, space): task for task in tasks}
        try:
            for future in concurrent.futures.as_completed(futures):
                future.result()
                drive, name, _ = futures[future]
                progress.step(f"{drive.name} {name}")
        except KeyboardInterrupt:
            for future in futures:
                future.cancel()
            return False
    return True


def gathered(drives, sets, mechanisms, space):
    """What zoo.json holds. The commit is that of the programs, which may be another than that of the sources beside this one."""
    runs = {(drive.name, name): dict(space.done[space.key_of(drive, options)]) for drive in drives
            for name, options in sets.items() if space.key_of(drive, options) in space.done}
    commits = {run.pop("commit") for run in runs.values() if "commit" in run}
    return {"commit": ", ".join(sorted(commits)), "date": datetime.date.today().isoformat(), "mechanisms": mechanisms,
            "drives": [{"name": drive.name, "kinds": drive.kinds, "floor_m": drive.floor, "has_truth": drive.has_truth,
                        "commands": drive.commands,
                        "runs": {name: runs[drive.name, name] for name in sets if (drive.name, name) in runs}}
                       for drive in drives]}


def text_of(zoo):
    """JSON with one line a drive."""
    drives = ",\n".join(json.dumps(drive) for drive in zoo["drives"])
    return json.dumps({**zoo, "drives": []})[:-2] + "\n" + drives + "\n]}\n"


def told(words):
    """The arguments without what says only where things lie."""
    kept, skip = [], False
    for word in words:
        if not skip and word.split("=")[0] not in ("--out", "--bin", "--data", "--jobs", "--page", "--compare"):
            kept.append(word)
        skip = not skip and word in ("--out", "--bin", "--data", "--jobs", "--page", "--compare")
    return kept


def parsed(words=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    place = parser.add_mutually_exclusive_group(required=True)
    place.add_argument("--out", type=pathlib.Path, help="folder of results and of what is kept to go on")
    place.add_argument("--from", type=pathlib.Path, dest="source", metavar="ZOO.json", help="run nothing")
    place.add_argument("--list", action="store_true", help="the simulated drives, and nothing else")
    parser.add_argument("--data", type=pathlib.Path, default=os.environ.get(
        "MATCHBOX_DATA", os.path.join(report.SOURCE, "..", "shared", "data")), help="folder of the recordings")
    parser.add_argument("--bin", type=pathlib.Path, metavar="DIR", help="devel space, in place of the one that is sourced")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--quick", action="store_true", help="a dozen simulated drives, the default alone")
    parser.add_argument("--others", type=int, metavar="N", help="drives of which none is in the zoo, another set for each N")
    parser.add_argument("--unseen", action="store_true", help="drives of worlds that the zoo does not have; with --others N another set")
    parser.add_argument("--no-mechanisms", action="store_true", help="the default alone")
    parser.add_argument("--no-recordings", action="store_true")
    parser.add_argument("--only", default="", metavar="REGEX", help="drives whose name has this")
    parser.add_argument("--only-world", action="append", default=[], choices=WORLDS + UNSEEN_WORLDS)
    parser.add_argument("--leave-out", action="append", default=[], choices=WORLDS + UNSEEN_WORLDS, metavar="WORLD",
                        help="a world that is not looked at while a number is fitted")
    parser.add_argument("--set", action="append", default=[], dest="overrides", metavar="KEY=VALUE", help="in every run")
    parser.add_argument("--drop-bags", action="store_true", help="delete the simulated and thinned bags at the end")
    parser.add_argument("--compare", type=pathlib.Path, metavar="OLD.json")
    parser.add_argument("--page", type=pathlib.Path, metavar="doc/results.md", help="write what each mechanism is worth into this page")
    return parser.parse_args(words)


def run_zoo(arguments):
    if arguments.bin:
        use_space(arguments.bin.resolve())
    space = Space(arguments)
    drives = chosen(arguments, space)
    if not drives:
        raise SystemExit("no drive is left")
    mechanisms = {} if arguments.quick or arguments.no_mechanisms else known_mechanisms(MECHANISMS, space)
    sets = configurations(mechanisms)
    is_whole = run_all(drives, sets, space, arguments.jobs)
    zoo = gathered(drives, sets, mechanisms, space)
    (arguments.out / "zoo.json").write_text(text_of(zoo))
    (arguments.out / "ZOO.md").write_text(zoo_report.report(
        zoo, report.heading("The zoo", "run_zoo.py", told(sys.argv[1:]))))
    if not is_whole:
        raise SystemExit("interrupted: the report is of what was run; the same command goes on from here")
    if arguments.drop_bags:
        shutil.rmtree(space.bags)
    return zoo


def main():
    arguments = parsed()
    if arguments.list:
        print("\n".join(f"{drive.name}: simulate {' '.join(drive.simulate_options())}" for drive in
                        drives_of(arguments)))
        return
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    zoo = json.loads(arguments.source.read_text()) if arguments.source else run_zoo(arguments)
    print("\n".join(zoo_report.default_table(zoo["drives"])))
    if arguments.page:
        arguments.page.write_text(zoo_report.with_section(arguments.page.read_text(), zoo_report.page_section(zoo)))
    if arguments.compare:
        print("\n" + zoo_report.comparison(json.loads(arguments.compare.read_text()), zoo), end="")
    failed = zoo_report.failures(zoo["drives"])
    if failed:
        raise SystemExit(f"{len(failed)} runs failed, such as: {failed[0]}")


if __name__ == "__main__":
    main()
