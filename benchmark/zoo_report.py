"""What the zoo's runs say: by kind of drive, and what each mechanism is worth there."""

import math

LEAST = 0.001  # [m]; what is below is the chance of a millimetre
WORST = 20  # drives that are listed
BEGIN = "<!-- zoo: generated, see benchmark/run_zoo.py --page -->\n"
END = "<!-- end of zoo -->\n"
CLEARLY = 1.05  # a mean ratio that is nearer to 1 says nothing


def geometric_mean(values):
    values = list(values)
    return math.exp(sum(map(math.log, values)) / len(values)) if values else None


def error_in(drive, configuration):
    """What counts of it: as much as the truth can tell at least. None where it has no truth, or failed."""
    run = drive["runs"].get(configuration, {})
    return None if run.get("ate_m") is None else max(run["ate_m"], drive["floor_m"], LEAST)


def ratios(drives, one, other):
    """Of the errors of two configurations, where both are known."""
    pairs = [(error_in(drive, one), error_in(drive, other)) for drive in drives]
    return [a / b for a, b in pairs if a is not None and b is not None]


def best_left_out(drive, mechanisms):
    """The least error of those with one mechanism left out."""
    errors = [error_in(drive, "-" + name) for name in mechanisms]
    return min((error for error in errors if error is not None), default=None)


def groups_of(drives):
    """Drives by kind, (factor, value), in the order they come; first all that are simulated, and all recordings."""
    groups = {("all", "simulated"): [], ("all", "recordings"): []}
    for drive in drives:
        is_recording = "recording" in drive["kinds"]
        groups["all", "recordings" if is_recording else "simulated"].append(drive)
    factors = list(dict.fromkeys(factor for drive in drives for factor in drive["kinds"]))
    for factor in factors:
        for drive in drives:
            if factor in drive["kinds"]:
                groups.setdefault((factor, drive["kinds"][factor]), []).append(drive)
    return {kind: group for kind, group in groups.items() if group}


def mean_of(drives, figure, configuration="default"):
    values = [drive["runs"][configuration][figure] for drive in drives
              if figure in drive["runs"].get(configuration, {})]
    return sum(values) / len(values) if values else None


def text_of(value, form="%.3f"):
    return "–" if value is None else form % value


def name_of(kind):
    factor, value = kind
    return f"{factor} {value}" + (" m" if factor == "distance" else "")


def default_table(drives):
    lines = ["| kind | drives | ATE: geometric mean [m] | worst [m] | of odometry [m] | of the scans lost | lost or unsure "
             "| CPU a scan [ms] |", "|" + "---|" * 8]
    for kind, group in groups_of(drives).items():
        errors = [error for error in (error_in(drive, "default") for drive in group) if error is not None]
        odometry = [drive["runs"]["default"]["odometry_m"] for drive in group
                    if drive["runs"].get("default", {}).get("odometry_m") is not None]
        lost, unsure, cpu = (mean_of(group, figure) for figure in ("lost", "unsure", "cpu_ms"))
        failed = sum("failed" in drive["runs"].get("default", {}) for drive in group)
        lines.append(
            f"| {name_of(kind)} | {len(group)}{f', {failed} failed' if failed else ''} | "
            f"{text_of(geometric_mean(errors), '%.4f')} | {text_of(max(errors, default=None))} | "
            f"{text_of(geometric_mean(max(value, LEAST) for value in odometry))} | "
            f"{text_of(lost and 100 * lost, '%.1f %%')} | {text_of(unsure and 100 * unsure, '%.1f %%')} | "
            f"{text_of(cpu, '%.2f')} |")
    return lines


def worth_table(drives, mechanisms):
    """*Default / without it*, and of each drive the default by the best with one left out."""
    lines = ["| kind | " + " | ".join(f"÷ without {name}" for name in mechanisms) + " | ÷ the best with one left out |",
             "|" + "---|" * (2 + len(mechanisms))]
    for kind, group in groups_of(drives).items():
        cells = [geometric_mean(ratios(group, "default", "-" + name)) for name in mechanisms]
        best = [(error_in(drive, "default"), best_left_out(drive, mechanisms)) for drive in group]
        cells.append(geometric_mean(a / b for a, b in best if a is not None and b is not None))
        if any(cell is not None for cell in cells):
            lines.append(f"| {name_of(kind)} | " + " | ".join(text_of(cell, "%.2f") for cell in cells) + " |")
    return lines


def alone_table(drives, mechanisms):
    """*Default / it alone*, and by none at all."""
    lines = ["| kind | ÷ none | " + " | ".join(f"÷ {name} alone" for name in mechanisms) + " |",
             "|" + "---|" * (2 + len(mechanisms))]
    for kind, group in groups_of(drives).items():
        cells = [geometric_mean(ratios(group, "default", other))
                 for other in ["none"] + ["+" + name for name in mechanisms]]
        if any(cell is not None for cell in cells):
            lines.append(f"| {name_of(kind)} | " + " | ".join(text_of(cell, "%.2f") for cell in cells) + " |")
    return lines


def worst_drives(drives):
    measured = [drive for drive in drives if error_in(drive, "default") is not None]
    return sorted(measured, key=lambda drive: -error_in(drive, "default"))[:WORST]


def worst_list(drives, mechanisms):
    lines = ["| drive | ATE [m] | of odometry [m] | lost or unsure | the best with one left out [m] |", "|" + "---|" * 5]
    commands = []
    for drive in worst_drives(drives):
        run = drive["runs"]["default"]
        unsure = text_of(run.get("unsure") and 100 * run["unsure"], "%.0f %%")
        lines.append(f"| {drive['name']} | {run['ate_m']:.3f} | {text_of(run.get('odometry_m'))} | {unsure} | "
                     f"{text_of(best_left_out(drive, mechanisms))} |")
        commands += [f"# {drive['name']}: {run['ate_m']:.3f} m"] + drive["commands"]
    return lines + ["", "```bash"] + commands + ["```"]


def failures(drives):
    return [f"- {drive['name']}, {configuration}: {run['failed']}"
            for drive in drives for configuration, run in drive["runs"].items() if "failed" in run]


def report(zoo, heading):
    drives, mechanisms = zoo["drives"], list(zoo["mechanisms"])
    floors = {drive["kinds"]["recording"]: drive["floor_m"] for drive in drives
              if "recording" in drive["kinds"] and drive["floor_m"]}
    lines = heading + [
        f"- programs: commit {zoo['commit']}",
        f"- {sum('recording' not in drive['kinds'] for drive in drives)} simulated drives, "
        f"{sum('recording' in drive['kinds'] for drive in drives)} of recordings, "
        f"{sum(len(drive['runs']) for drive in drives)} runs",
        "- ATE: root mean square distance from the truth after SE(2) alignment; of intel the mean error of its verified "
        "relations. In means and ratios errors below 1 mm count as 1 mm"]
    if floors:
        lines.append("- below what the truth itself is good for, errors count as equal [m]: "
                     + ", ".join(f"{name} {floor:g}" for name, floor in floors.items())
                     + ". But for jarvis_circular (reflectors) and intel (relations) these are guesses of the errors of a particle "
                     "filter, whose poses came with the logs")
    lines.append("- without truth, for shares and time alone: " + (", ".join(dict.fromkeys(
        drive["kinds"]["recording"] for drive in drives
        if "recording" in drive["kinds"] and not drive["has_truth"])) or "none"))
    lines += ["", "## By default", "", *default_table(drives)]
    if mechanisms:
        lines += ["", "## Default ÷ without", "",
                  "Geometric means of the ratios of the errors: above 1 a mechanism does harm there, below 1 it helps. *The best*: of "
                  "each drive, so that chance makes it larger than 1.", "", *worth_table(drives, mechanisms),
                  "", "## Default ÷ alone", "", "With all others off.", "", *alone_table(drives, mechanisms)]
    lines += ["", f"## The worst {WORST}", "", *worst_list(drives, mechanisms)]
    failed = failures(drives)
    if failed:
        lines += ["", "## Failed", "", *failed]
    options = [f"- {name}: off by `{' '.join(sets)}`" for name, sets in zoo["mechanisms"].items()]
    if options:
        lines += ["", "## Mechanisms", "", *options]
    return "\n".join(lines) + "\n"


def worth_of(drives, mechanism):
    """Ratios by kind, the worst first, where they are not of one drive alone."""
    found = [(geometric_mean(values), kind) for kind, values in
             ((kind, ratios(group, "default", "-" + mechanism)) for kind, group in groups_of(drives).items())
             if kind[0] != "all" and len(values) > 1]
    return sorted(found, key=lambda one: -one[0])


def few(found, number=4):
    return ", ".join(f"{name_of(kind)} {ratio:.2f}" for ratio, kind in found[:number]) or "–"


def page_section(zoo):
    """For doc/results.md: what each mechanism is worth where, worst first."""
    drives, mechanisms = zoo["drives"], list(zoo["mechanisms"])
    simulated = [drive for drive in drives if "recording" not in drive["kinds"]]
    recorded = [drive for drive in drives if "recording" in drive["kinds"]]
    rows = []
    for name in mechanisms:
        worth = worth_of(drives, name)
        means = [geometric_mean(ratios(some, "default", "-" + name)) for some in (simulated, recorded)]
        harm = [one for one in worth if one[0] > CLEARLY]
        help_ = [one for one in reversed(worth) if one[0] < 1.0 / CLEARLY]
        rows.append((-(means[0] or means[1] or 0.0),
                     f"| `{name}` | {text_of(means[0], '%.2f')} | {text_of(means[1], '%.2f')} | {few(harm)} | {few(help_)} |"))
    lines = [f"Of {len(simulated)} simulated drives and {len(recorded)} of recordings, at {zoo['commit']}, {zoo['date']}. "
             "*Default ÷ without it*, geometric means: above 1 it does harm, below 1 it helps.", "", "<!-- figures: ZOO.md -->",
             "| mechanism | simulated | recordings | does most harm | helps most |", "|" + "---|" * 5]
    lines += [row for _, row in sorted(rows)]
    return "\n".join(lines) + "\n"


def with_section(page, section):
    """A page with what is between its markers made anew."""
    begin, end = page.find(BEGIN), page.find(END)
    if begin < 0 or end < begin:
        raise SystemExit(f"--page: the page has no '{BEGIN.strip()}' and '{END.strip()}'")
    return page[:begin + len(BEGIN)] + "\n" + section + "\n" + page[end:]


def comparison(old, new):
    """By kind, of the drives that both have: the default then and now."""
    before = {drive["name"]: drive for drive in old["drives"]}
    lines = [f"Before: {old['commit']}, {old['date']}; now: {new['commit']}, {new['date']}", "",
             "| kind | drives | before [m] | now [m] | now ÷ before | worst, before [m] | now [m] | lost or unsure, before | now "
             "| CPU a scan, now ÷ before |", "|" + "---|" * 10]
    for kind, group in groups_of([drive for drive in new["drives"] if drive["name"] in before]).items():
        pairs = [(before[drive["name"]], drive) for drive in group]
        errors = [(error_in(a, "default"), error_in(b, "default")) for a, b in pairs]
        errors = [(a, b) for a, b in errors if a is not None and b is not None]
        unsure = [mean_of([pair[i] for pair in pairs], "unsure") for i in (0, 1)]
        cpu = [mean_of([pair[i] for pair in pairs], "cpu_ms") for i in (0, 1)]
        cells = [text_of(geometric_mean(pair[i] for pair in errors), "%.4f") for i in (0, 1)]
        cells.append(text_of(geometric_mean(b / a for a, b in errors), "%.2f"))
        cells += [text_of(max((pair[i] for pair in errors), default=None)) for i in (0, 1)]
        cells += [text_of(None if share is None else 100 * share, "%.1f %%") for share in unsure]
        cells.append(text_of(cpu[1] / cpu[0] if cpu[0] and cpu[1] else None, "%.2f"))
        lines.append(f"| {name_of(kind)} | {len(pairs)} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"
