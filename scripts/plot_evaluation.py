#!/usr/bin/python3
"""plot_evaluation: draws what `evaluate` measured. Reads the figure as JSON from stdin and writes it as
PNG to stdout; `evaluate --plot` runs it and names the file.

The member `metric` says which figure it is; `ate`, `rpe`, `relations` and `maps` below say what else it has.
Lengths are in metres, angles in radians, stamps in seconds."""

import io
import itertools
import json
import math
import os
import sys

# After Okabe and Ito: told apart also by the colour-blind, and in order of how well.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
DASHES = ("-", "--", ":")
TRUTH_COLOR = "#000000"
CORNER_COLOR = "#D62728"
# Of cells. Neighbouring areas are to differ: light, so that walls and corners stay clear.
CELL_COLORS = {"#": (40, 44, 52), ".": (255, 255, 255), "?": (222, 224, 228), "a": (166, 206, 227),
               "b": (178, 223, 138), "c": (253, 191, 111), "d": (202, 178, 214), "e": (255, 255, 153),
               "f": (141, 211, 199)}
DPI = 130


def styles():
    """How estimates are drawn: every colour solid, then every colour dashed, and so on."""
    return itertools.cycle({"color": color, "linestyle": dash} for dash in DASHES for color in COLORS)


def labels_of(estimates):
    """Names for the legend: of the files, or their paths where two files have one name."""
    paths = [estimate["name"] for estimate in estimates]
    names = [os.path.basename(path) for path in paths]
    if len(set(names)) < len(names):
        names = paths
    # A dollar would begin a formula, and a label that begins with a low line is left out.
    return ["./" * name.startswith("_") + name.replace("$", r"\$") for name in names]


def put_legend_above(axes, columns=1):
    """Above the axes, where it hides no data."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=columns, frameon=False,
                borderaxespad=0.2)


def finish(axes, x_label, y_label):
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.grid(True, color="#DDDDDD", linewidth=0.6)
    axes.set_axisbelow(True)


def ate(pyplot, data):
    """`truth`: x, y; `estimates`: name, rmse, and of the compared poses stamp, x, y, error."""
    figure, (plan, over_time) = pyplot.subplots(
        2, 1, figsize=(8, 9), gridspec_kw={"height_ratios": (3, 1)}, constrained_layout=True)
    plan.plot(data["truth"]["x"], data["truth"]["y"], color=TRUTH_COLOR, linewidth=4, alpha=0.35,
              label="truth")
    start = min(estimate["stamp"][0] for estimate in data["estimates"])
    for estimate, label, style in zip(data["estimates"], labels_of(data["estimates"]), styles()):
        label += f" (rmse {estimate['rmse']:.3f} m)"
        plan.plot(estimate["x"], estimate["y"], linewidth=1.2, label=label, **style)
        over_time.plot([stamp - start for stamp in estimate["stamp"]], estimate["error"],
                       linewidth=1.2, **style)
    plan.set_aspect("equal", adjustable="datalim")
    put_legend_above(plan)
    finish(plan, "x [m]", "y [m]")
    over_time.set_ylim(bottom=0.0)
    finish(over_time, "time [s]", "position error [m]")
    return figure


def rpe(pyplot, data):
    """`measures`: name, and `estimates` with name and of each pair stamp, translation, rotation."""
    measures = [measure for measure in data["measures"]
                if any(estimate["stamp"] for estimate in measure["estimates"])]
    figure, rows = pyplot.subplots(len(measures), 2, figsize=(11, 1 + 2.1 * len(measures)),
                                   sharex=True, squeeze=False, constrained_layout=True)
    start = min(estimate["stamp"][0] for measure in measures for estimate in measure["estimates"]
                if estimate["stamp"])
    for number, (measure, row) in enumerate(zip(measures, rows), start=1):
        estimates = measure["estimates"]
        for estimate, label, style in zip(estimates, labels_of(estimates), styles()):
            times = [stamp - start for stamp in estimate["stamp"]]
            row[0].plot(times, estimate["translation"], linewidth=0.9, label=label, **style)
            row[1].plot(times, [math.degrees(angle) for angle in estimate["rotation"]],
                        linewidth=0.9, label=label, **style)
        x_label = "time of the first pose [s]" if number == len(measures) else ""
        finish(row[0], x_label, f"{measure['name']} [m]")
        finish(row[1], x_label, f"{measure['name']} [deg]")
        row[0].set_ylim(bottom=0.0)
        row[1].set_ylim(bottom=0.0)
    put_legend_above(rows[0][0])
    figure.suptitle("Relative pose error: translation (left) and rotation (right)")
    return figure


def relations(pyplot, data):
    """`estimates`: name, and of each relation translation and rotation."""
    figure, panels = pyplot.subplots(1, 2, figsize=(11, 5), sharey=True, constrained_layout=True)
    for estimate, label, style in zip(data["estimates"], labels_of(data["estimates"]), styles()):
        degrees = [math.degrees(angle) for angle in estimate["rotation"]]
        for axes, errors, smallest in zip(panels, (estimate["translation"], degrees), (1e-4, 1e-3)):
            shares = [100.0 * (i + 1) / len(errors) for i in range(len(errors))]
            # The axis is logarithmic and has no zero.
            axes.plot([max(error, smallest) for error in sorted(errors)], shares, linewidth=1.6,
                      label=label, **style)
    for axes in panels:
        axes.set_xscale("log")
        axes.set_ylim(0.0, 100.0)
    finish(panels[0], "translation error [m]", "relations with at most this error [%]")
    finish(panels[1], "rotation error [deg]", "")
    put_legend_above(panels[0])
    return figure


def maps(pyplot, data):
    """`maps`: name, rows of cells from the top by the keys of CELL_COLORS, number of enclosed areas, and
    corners in cells from the lower left one. All are drawn to one scale, a cell at least a dot."""
    import numpy
    colors = numpy.zeros((128, 3), dtype=numpy.uint8)
    for key, color in CELL_COLORS.items():
        colors[ord(key)] = color
    highest = max(len(one["rows"]) for one in data["maps"])
    widths = [len(one["rows"][0]) for one in data["maps"]]
    inches = max(8.0 / highest, 1.0 / DPI)  # a cell
    figure, panels = pyplot.subplots(
        1, len(widths), figsize=(max(3.0 * len(widths), inches * sum(widths)), inches * highest + 1.0),
        squeeze=False, gridspec_kw={"width_ratios": widths}, constrained_layout=True)
    for axes, one, label in zip(panels[0], data["maps"], labels_of(data["maps"])):
        cells = numpy.array([numpy.frombuffer(row.encode(), dtype=numpy.uint8) for row in one["rows"]])
        height, width = cells.shape
        axes.imshow(colors[cells], extent=(0, width, 0, height), interpolation="nearest")
        axes.plot([x for x, _ in one["corners"]], [y for _, y in one["corners"]], "o",
                  color=CORNER_COLOR, markersize=4)
        axes.set_ylim(0, highest)
        axes.set_title(f"{label}\ncorners {len(one['corners'])}  areas {one['areas']}")
        axes.axis("off")
    return figure


def refuse(text):
    """Ends with one line, for wrong usage."""
    print(f"plot_evaluation: {text}; `evaluate --plot` runs it", file=sys.stderr)
    sys.exit(2)


def draw(pyplot, stream):
    """The figure of which JSON is read from `stream`."""
    figures = {"ate": ate, "rpe": rpe, "relations": relations, "map": maps}
    try:
        data = json.load(stream)
    except ValueError as error:  # of JSON, or of bytes that are no text
        refuse(f"standard input is not JSON: {error}")
    metric = data.get("metric") if isinstance(data, dict) else None
    if metric not in list(figures):  # which may be no text
        refuse(f"the JSON has no metric that is one of {', '.join(figures)}")
    try:
        return figures[metric](pyplot, data)
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        refuse(f"the JSON is no figure of {metric} ({type(error).__name__}: {error})")


def main():
    if "--help" in sys.argv[1:] or "-h" in sys.argv[1:]:
        print(__doc__)
        return
    if len(sys.argv) > 1:
        refuse(f"unknown option {sys.argv[1]}; it takes none but --help")
    if sys.stdin.isatty():
        refuse("standard input is a terminal, not JSON")
    try:
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
    except ImportError as error:
        sys.exit(f"matplotlib cannot be loaded ({error}); install python3-matplotlib")
    pyplot.rcParams.update({"font.size": 11, "axes.spines.top": False, "axes.spines.right": False,
                            "axes.formatter.useoffset": False})
    figure = draw(pyplot, sys.stdin)
    png = io.BytesIO()
    figure.savefig(png, format="png", dpi=DPI)
    sys.stdout.buffer.write(png.getvalue())


if __name__ == "__main__":
    main()
