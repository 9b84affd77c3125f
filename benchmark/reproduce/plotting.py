"""How all figures look."""

import matplotlib

matplotlib.use('Agg')
from matplotlib import pyplot  # noqa: E402  the backend comes first

# After Okabe and Ito: told apart also by the colour-blind. As in plot_evaluation.
BLUE, VERMILION, GREEN, GREY = '#0072B2', '#D55E00', '#009E73', '#777777'

pyplot.rcParams.update({'font.size': 12, 'axes.spines.top': False, 'axes.spines.right': False,
                        'axes.formatter.useoffset': False, 'legend.framealpha': 1.0})


def finish(axes, x_label, y_label):
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.grid(True, color='#DDDDDD', linewidth=0.6)
    axes.set_axisbelow(True)


def legend_above(axes, columns=2, **options):
    """Above the axes, where it hides no data."""
    axes.legend(loc='lower left', bbox_to_anchor=(0.0, 1.0), ncol=columns, frameon=False,
                borderaxespad=0.2, handletextpad=0.5, columnspacing=1.2, **options)


def save(figure, path):
    figure.savefig(path, dpi=110)
    pyplot.close(figure)
