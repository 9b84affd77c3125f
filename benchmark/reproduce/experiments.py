"""What is measured: the matchers, tests and figures of the paper ("The Scan Matchers Research and Comparison:
Monte-Carlo, Olson and Hough"), and the sizes of a run. Everything else takes it from here."""

import collections
import math
import os
import shlex


class Mistake(Exception):
    """Something is asked for that cannot be."""


# The order of the tables, and how people read the names.
MATCHERS = {'monte_carlo': 'Monte-Carlo', 'olson': 'Olson', 'hough': 'Hough'}
BASELINE = 'odometry_only'
# Parameters that the workflow sets.
OWNED = {'matcher', 'seed'}
NAMES = dict(MATCHERS, **{BASELINE: 'OdometryOnly'})

# error: bounds of the guess's error in x, y [m] and heading [rad]; table: of the paper.
Test = collections.namedtuple('Test', 'table title world error')
TESTS = {
    'A': Test('II', 'straight world, odometry without error', 'rooms', (0.0, 0.0)),
    'B': Test('III', 'straight world, odometry off by up to 0.2 m and 0.2 rad', 'rooms', (0.2, 0.2)),
    'C': Test('IV', 'random world, odometry without error', 'random', (0.0, 0.0)),
    'D': Test('V', 'random world, odometry off by up to 0.2 m and 0.2 rad', 'random', (0.2, 0.2)),
}

# The paper's own figures, tables II to V, one run on a Core i7-860 of 2.8 GHz, it seems: time [s], error
# along x and y [m], of the heading [rad]. Its Hough matcher finds no translation.
PAPER = {
    'A': {'monte_carlo': (0.02, 0.0, 0.0, 0.0), 'olson': (0.3, 0.0, 0.0, 0.0),
          'hough': (0.2, None, None, 0.0)},
    'B': {'monte_carlo': (0.02, 0.011, 0.009, 0.02), 'olson': (0.3, 0.001, 0.001, 0.001),
          'hough': (0.1, None, None, 0.008)},
    'C': {'monte_carlo': (0.3, 0.0, 0.0, 0.0), 'olson': (2.7, 0.0, 0.0, 0.0),
          'hough': (0.8, None, None, 0.008)},
    'D': {'monte_carlo': (0.3, 0.08, 0.09, 0.05), 'olson': (2.7, 0.0005, 0.0004, 0.001),
          'hough': (0.8, None, None, 0.016)},
}

# The paper does not say how noisy its laser is: without noise, and with that of a common laser [m].
NOISES = {'exact': 0.0, '1cm': 0.01}

# The bag of figures 2 to 9, where none is given.
SIMULATED_RECORDING = 'rooms-1cm'

# A row of table I: time against one quantity, all else alike. `points` are (x, beams, parameters) for each
# measurement. x is what the paper's complexity is written in; of the Hough domain it is the cells for each
# metre of a scan's reach, which is measured.
Complexity = collections.namedtuple('Complexity', 'matcher quantity unit paper how points')

# Every beam counts, as in the paper; by default the matchers thin their points out first.
ALL_POINTS = {'monte_carlo': {'monte_carlo/search_points': 1000000, 'monte_carlo/enough_score': 1},
              'olson': {'olson/point_spacing': 0},
              'hough': {'hough/point_spacing': 0}}
PAPER_COST = {'monte_carlo': 'n · tries', 'olson': 'n · n_x · n_y · n_θ', 'hough': 'n + n_ρ · n_θ'}
BEAMS = (260, 520, 1040, 2080, 4160)


def beams_sweep(matcher):
    return Complexity(matcher, 'n', 'beams', PAPER_COST[matcher],
                      'beams of a scan, none of them thinned out',
                      [(beams, beams, ALL_POINTS[matcher]) for beams in BEAMS])


def tries_sweep():
    def options(tries):
        return {'monte_carlo/max_tries': tries, 'monte_carlo/max_failed_tries': tries,
                'monte_carlo/covariance_samples': 0, 'monte_carlo/refine_iterations': 0}
    return Complexity('monte_carlo', 'tries', 'poses', PAPER_COST['monte_carlo'],
                      'poses drawn, without refinement and covariance',
                      [(tries, 1040, options(tries)) for tries in (250, 500, 1000, 2000, 4000, 8000)])


def lattice_sweep():
    step_xy, step_theta = 0.025, 0.005
    points = []
    for xy, theta in ((0.2, 0.2), (0.4, 0.2), (0.4, 0.4), (0.8, 0.4), (0.8, 0.8), (1.6, 0.8)):
        poses = (2 * round(xy / step_xy) + 1) ** 2 * (2 * round(theta / step_theta) + 1)
        points.append((poses, 1040, {
            'olson/window_xy': xy, 'olson/window_theta': theta, 'olson/step_xy': step_xy,
            'olson/step_theta': step_theta, 'olson/least_rival': 1}))
    return Complexity('olson', 'n_x · n_y · n_θ', 'poses', PAPER_COST['olson'],
                      'poses of the lattice; bounds rule most of them out unseen', points)


def domain_sweep():
    points = []
    for angles, cell in ((90, 0.06), (128, 0.042), (180, 0.03), (256, 0.021), (360, 0.015),
                         (512, 0.0105), (1024, 0.006)):
        # Columns reach to both sides.
        points.append((round(angles * 2.0 / cell), 1040, {'hough/angles': angles, 'hough/rho_cell': cell}))
    return Complexity('hough', 'n_ρ · n_θ', 'cells', PAPER_COST['hough'],
                      'cells of the Hough domain, as far as half of the scans reach', points)


COMPLEXITIES = {
    'monte_carlo-beams': beams_sweep('monte_carlo'),
    'monte_carlo-tries': tries_sweep(),
    'olson-beams': beams_sweep('olson'),
    'olson-lattice': lattice_sweep(),
    'hough-beams': beams_sweep('hough'),
    'hough-domain': domain_sweep(),
}

# A search that the budgets name (DESIGN 6), as the tables do not: in the tables the window follows from the
# guess's uncertainty. The limit is of the median time [ms]; guesses are off by up to the window, but for the
# large one, where that would leave the map.
Budget = collections.namedtuple('Budget', 'matcher title limit error settings')


def olson_window(xy, theta, step_xy, step_theta):
    return {'olson/window_xy': xy, 'olson/window_theta': theta, 'olson/step_xy': step_xy,
            'olson/step_theta': step_theta}


BUDGETS = {
    'olson-window': Budget('olson', '±0.2 m, ±0.2 rad, lattice 1 cm × 0.1°', 2.0, (0.2, 0.2),
                           olson_window(0.2, 0.2, 0.01, 0.001745)),
    'olson-loop': Budget('olson', '4 m × 90° (±2 m, ±45°), lattice 3 cm × 0.5°', 20.0, (1.0, 0.7),
                         olson_window(2.0, 0.7854, 0.03, 0.008727)),
}
BUDGET_BAG = 'rooms-1cm'

# What follows is not in the paper. All three matchers end in the same refinement, which makes their answers
# alike wherever their searches come near enough. So the tables tell the searches' own answers, too; these are
# their times without it, in tests B and D, range noise 1 cm.
SEARCHES = ('B', 'D')
SEARCH_ONLY = {matcher + '/refine_iterations': 0 for matcher in MATCHERS}

# A match that ends this near the truth, in m and rad, has found the place.
FOUND = (0.05, math.radians(0.5))

# Guesses that are off by any share of `far`, in m and rad, all sizes as often, and what the matchers are told
# of it: their windows, or the spread of their draws, follow from that. Range noise 1 cm.
Basin = collections.namedtuple('Basin', 'title world told')
FAR = (1.0, math.radians(45.0))
BASIN_BINS = 10
BASINS = {
    '%s-%s' % (world, name): Basin('%s, told ±%g m and ±%.3g°' % (title, told[0], math.degrees(told[1])), world, told)
    for world, title in (('rooms', 'straight world'), ('random', 'random world'))
    for name, told in (('narrow', (0.2, 0.2)), ('wide', FAR))}

# Scans that are worse: fewer beams, noise [m], a share of beams that end on something small before the wall.
# The guess is off as in tests B and D, and the matchers are told so.
Hard = collections.namedtuple('Hard', 'world beams noise outliers')
HARD_ERROR = (0.2, 0.2)
HARD = {'%s-%d-%gcm-%g' % (world, beams, 100.0 * noise, 100.0 * outliers): Hard(world, beams, noise, outliers)
        for world in ('rooms', 'random') for beams in (1040, 181)
        for noise, outliers in ((0.0, 0.0), (0.01, 0.0), (0.05, 0.0), (0.01, 0.2), (0.01, 0.4), (0.05, 0.4))}


def bag_together(kind, name):
    """The name of the bag of a job in which all matchers match the same pairs."""
    worlds = {'searches': lambda: TESTS[name].world, 'basins': lambda: BASINS[name].world}
    return 'hard-' + name if kind == 'hard' else worlds[kind]() + '-1cm'


# pairs: trials of a cell of tables II to V; complexity_pairs: of a point of table I; basin_pairs: of all bins
# of a basin; hard_pairs: of a row of worse scans; duration: of the bags [s], 0 is the whole;
# complexity_duration: also of those of worse scans.
Size = collections.namedtuple(
    'Size', 'pairs complexity_pairs basin_pairs hard_pairs duration complexity_duration recording')
SIZES = {'full': Size(1000, 200, 2000, 300, 0, 60, 0), 'quick': Size(100, 20, 100, 20, 30, 10, 60)}


def simulated_bags(size):
    """By name: the world and options of `simulate`."""
    bags = {}
    for world in sorted({test.world for test in TESTS.values()}):
        for name, noise in NOISES.items():
            # A laser without noise loses no reading either.
            dropout = {} if noise else {'dropout': 0}
            bags['%s-%s' % (world, name)] = dict(
                dropout, **{'world': world, 'range-noise': noise, 'duration': size.duration})
    for name in COMPLEXITIES:
        for _, beams, _ in COMPLEXITIES[name].points:
            bags['beams-%d' % beams] = {'world': 'rooms', 'beams': beams,
                                        'duration': size.complexity_duration}
    for name, hard in HARD.items():
        bags['hard-' + name] = {'world': hard.world, 'beams': hard.beams, 'range-noise': hard.noise,
                                'outliers': hard.outliers, 'duration': size.complexity_duration}
    return bags


def settings_of(matcher, settings):
    """Those of the user's settings that concern a matcher: other matchers' own ones are left out."""
    others = set(NAMES) - {matcher}
    return {key: value for key, value in settings.items() if key.split('/')[0] not in others}


def check_settings(settings, where):
    """What the workflow itself sets differs from cell to cell, and is not the user's."""
    for key in OWNED & set(settings):
        raise Mistake('%s: %s is not to be set here: the workflow sets it for each job' % (where, key))


def words(options, where):
    """Options of a program, which the user gives as one text."""
    try:
        return shlex.split(options or '')
    except (ValueError, AttributeError, TypeError) as error:
        raise Mistake('%s: %s' % (where, error))


def check_map_options(options, where):
    given = words(options, where)
    for word, following in zip(given, given[1:] + ['']):
        flag, _, value = word.partition('=')
        if flag in ('--matcher', '--seed', '--out', '--quiet', '--help'):
            raise Mistake('%s: %s is not to be given here: the workflow gives it to each job' % (where, flag))
        if flag == '--set':
            key = (value if '=' in word else following).partition('=')[0]
            check_settings({key: None}, where)


# bags: paths; truth: a path or None; options: lists of words for map_bag, and for `evaluate ate`.
Recording = collections.namedtuple('Recording', 'bags truth map_options truth_options')


def truth_options(truth, given):
    """Options of `evaluate` for a truth file; Stata's truth is of the laser, and in its clock."""
    if given is None and truth and os.path.basename(truth).endswith('.gt.laser.poses'):
        return '--lever-arm 0.275 --find-offset'
    return given or ''


def recording(entry, folder='', duration=0):
    """What an entry with `bag`, `truth`, `map_options` and `truth_options` says; paths are seen from the
    folder. Without a bag it is the simulated one. A duration caps what is mapped."""
    if not entry.get('bag'):
        name = os.path.join('bags', SIMULATED_RECORDING)
        return Recording([name + '.bag'], name + '.tum', [], [])
    bags = [entry['bag']] if isinstance(entry['bag'], str) else entry['bag']
    truth = entry.get('truth')
    options = words(entry.get('map_options'), 'map_options')
    if duration and not any(word.startswith('--duration') for word in options):
        options += ['--duration', str(duration)]
    return Recording([os.path.join(folder, bag) for bag in bags],
                     os.path.join(folder, truth) if truth else None, options,
                     words(truth_options(truth, entry.get('truth_options')), 'truth_options'))


def flags(options):
    """Options of a program, as words of the shell."""
    return ' '.join('--%s %s' % (key, shlex.quote(str(value))) for key, value in options.items())
