"""Which drives the zoo has: worlds, sensors, odometry, distances between scans and faults, so that all pairs of them occur."""

import itertools
import math
import random
import zlib

from run_faults import FAULTS as FAULT_OPTIONS

WORLDS = ("rooms", "atrium", "glass", "street", "hall", "hotel", "corridor", "loop", "campus", "random")
UNSEEN_WORLDS = ("warehouse", "garage", "park", "mine", "greenhouse")  # no number of the engine was chosen on these
SENSORS = ("utm30", "sick180", "lds01", "lds01_as_sent", "rplidar_a1", "narrow120", "narrow90", "depth_camera",
           "ranger32", "in_parts")
ODOMETRY = ("perfect", "good", "bad", "awful", "none")
DISTANCES = (0.03, 0.1, 0.3, 1.0, 1.5)  # [m] between scans
FAULTS = ("none", "freeze", "heading slip", "jump 1 rad", "dropout", "people", "kidnap")
FACTORS = {"world": WORLDS, "sensor": SENSORS, "odometry": ODOMETRY, "distance": DISTANCES, "fault": FAULTS}

SPEED = 0.5  # [m/s], at most
WAYS = {0.03: 24, 0.1: 60, 0.3: 120, 1.0: 250, 1.5: 330}  # [m] driven, by the distance between scans
ENDING = {"corridor": 50, "loop": 118, "random": 42}  # [m]; ways that end there, and not where they begin
LAPS = {"rooms": 100, "atrium": 100, "glass": 100, "street": 60, "hall": 100,
        "warehouse": 180, "garage": 120, "park": 85, "mine": 90, "greenhouse": 180}  # [m], at least; others are longer than any drive, or end
SHORTER = {"in_parts": 0.25}  # drives of a sensor that sends ten scans a turn
SWEEPS = {"lds01": 5.0, "lds01_as_sent": 5.0, "rplidar_a1": 5.5, "in_parts": 10.0}  # turns [1/s]; a scan takes one, however seldom it is
OF_ODOMETRY = ("freeze", "heading slip", "jump 1 rad")

# What is not tried together.
SENSELESS = (
    ("odometry", ("none",), "fault", OF_ODOMETRY),  # there is none that could fail
    ("odometry", ("none",), "distance", (1.0, 1.5)),  # nor anything else that says where a robot turned
    ("odometry", ("none",), "sensor", ("depth_camera", "ranger32", "in_parts")),
    ("odometry", ("none",), "world", ("corridor",)),  # and nothing that a laser sees along it
    ("sensor", ("in_parts",), "distance", (0.3, 1.0, 1.5)),  # nobody sends all parts of a turn, and then none for metres
)
DRIVES = 150  # pairs take some 110; the others have pairs that are rare so far, and no fault


def go_together(one, other):
    """Whether two values of factors, (name, value) each, may be those of one drive."""
    return not any(
        (a == one[0] and one[1] in these and b == other[0] and other[1] in those)
        or (a == other[0] and other[1] in these and b == one[0] and one[1] in those)
        for a, these, b, those in SENSELESS)


def allowed_pairs(factors):
    values = [(name, value) for name in factors for value in factors[name]]
    return [pair for pair in itertools.combinations(values, 2) if pair[0][0] != pair[1][0] and go_together(*pair)]


def pairs_of(row):
    return set(itertools.combinations(row, 2))


def completed(row, factors, worth):
    """A row with a value of each factor: those that are worth most together with what it has, the first of equals."""
    for name in factors:
        if any(name == factor for factor, _ in row):
            continue
        fitting = [(name, value) for value in factors[name] if all(go_together((name, value), other) for other in row)]
        row = row + [max(fitting, key=lambda one: worth(one, row))]
    return tuple(sorted(row, key=lambda one: list(factors).index(one[0])))


def covering_rows(factors, number):
    """Rows in which all allowed pairs occur, and then more up to the number; always the same ones."""
    order = {name: i for i, name in enumerate(factors)}
    missing = dict.fromkeys(allowed_pairs(factors))
    used = dict.fromkeys(missing, 0)
    faults = {("fault", value) for value in factors.get("fault", ())[1:]}
    rows = []

    def pair(a, b):
        return (a, b) if order[a[0]] < order[b[0]] else (b, a)

    def by_missing(one, row):
        """Of equals the one that is rare so far; but few drives have a fault, so that one has to be worth it."""
        found = sum(pair(one, other) in missing for other in row)
        if one[0] == "fault":
            return (found if found > 1 else 0), 0
        return found, -sum(used[pair(one, other)] for other in row)

    def by_rareness(one, row):
        return one not in faults, -sum(used[pair(one, other)] for other in row)

    def take(row):
        rows.append(row)
        for one in pairs_of(row):
            missing.pop(one, None)
            used[one] += 1

    while missing:
        take(completed(list(next(iter(missing))), factors, by_missing))
    while len(rows) < number:
        candidates = (completed(list(one), factors, by_rareness)
                      for one in sorted(used, key=used.get) if not faults & set(one))
        take(next(row for row in candidates if row not in rows))
    return rows


class Drive:
    """A simulated one; its name says all of it, and its seed comes from the name."""

    def __init__(self, world, sensor, odometry, distance, fault):
        self.kinds = {"world": world, "sensor": sensor, "odometry": odometry, "distance": distance, "fault": fault}
        self.name = "-".join(str(value).replace(" ", "_") for value in self.kinds.values())
        self.seed = zlib.crc32(self.name.encode()) % 100000
        self.speed = min(SPEED, round(distance * SWEEPS.get(sensor, 100.0), 3))

    def simulate_options(self):
        kinds = self.kinds
        way = WAYS[kinds["distance"]] * SHORTER.get(kinds["sensor"], 1.0)
        options = ["--world", kinds["world"], "--seed", self.seed, "--sensor", kinds["sensor"],
                   "--odometry", kinds["odometry"], "--speed", self.speed,
                   "--scan-rate", round(self.speed / kinds["distance"], 4), "--odometry-rate", 50]
        if way < ENDING.get(kinds["world"], math.inf):
            options += ["--duration", round(way / self.speed)]
        if kinds["world"] in LAPS:
            options += ["--laps", math.ceil(way / LAPS[kinds["world"]])]
        for fault in FAULT_OPTIONS[kinds["fault"]]:
            options += ["--fault", fault]
        return list(map(str, options))

    def map_options(self):
        return ["--no-odom"] if self.kinds["odometry"] == "none" else []


def shuffled(factors, number):
    """The same values in another order, so that other ones meet; `none`, of faults the usual one, stays the first."""
    order = random.Random(number)
    return {name: tuple(values[:1]) * (name == "fault") + tuple(order.sample(rest, len(rest)))
            for name, values in factors.items() for rest in [values[1:] if name == "fault" else values]}


def all_drives(others=None):
    """The zoo's; or others, a set for each number, to judge on what was chosen on the zoo's."""
    if others is None:
        return [Drive(*(value for _, value in row)) for row in covering_rows(FACTORS, DRIVES)]
    known = {drive.name for drive in all_drives()}
    drives = [Drive(*(value for _, value in row)) for row in covering_rows(shuffled(FACTORS, others), DRIVES)]
    return [drive for drive in drives if drive.name not in known]


def unseen_drives(others=None):
    """Of the worlds that the zoo does not have; or others, of which none is among these, a set for each number."""
    factors = {**FACTORS, "world": UNSEEN_WORLDS}
    if others is None:
        return [Drive(*(value for _, value in row)) for row in covering_rows(factors, DRIVES // 2)]
    known = {drive.name for drive in unseen_drives()}
    drives = [Drive(*(value for _, value in row)) for row in covering_rows(shuffled(factors, others), DRIVES // 2)]
    return [drive for drive in drives if drive.name not in known]


def quick_drives(drives, number=12):
    """So many that have most values of all factors."""
    missing = {one for drive in drives for one in drive.kinds.items()}
    chosen = []
    while len(chosen) < number:
        best = max((drive for drive in drives if drive not in chosen),
                   key=lambda drive: len(missing & set(drive.kinds.items())))
        chosen.append(best)
        missing -= set(best.kinds.items())
    return chosen
