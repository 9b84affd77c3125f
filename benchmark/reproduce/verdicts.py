"""What is asked of a matcher in each test (DESIGN 6), and whether it does it, in words."""

from experiments import BUDGETS, MATCHERS, NAMES, NOISES

MEDIAN_MM = 1.0
MEDIAN_MRAD = 0.5
# Share of trials that succeed, where the guess is wrong.
SUCCESS = 0.99
SUCCESS_OF = {('D', 'hough'): 0.95}
# Median time of a match in every test [ms], 1040 beams, on one core. Olson's is asked for given windows: see
# BUDGETS.
TIME_MS = {'monte_carlo': 1.0, 'hough': 1.5}
# A scan through the whole of map_bag, map update included [ms].
SCAN_MS = 2.0
NOT_MEASURED = 'the memory of a map of 100 m × 100 m (≤ 100 MB)'


def least_success(test, matcher):
    return SUCCESS_OF.get((test, matcher), SUCCESS) if test in 'BD' else 0.0


def name_of(row):
    return '%s in test %s, range noise %g cm' % (NAMES[row['matcher']], row['test'], 100.0 * NOISES[row['noise']])


def accuracy_misses(row):
    """Sentences, one for each demand that a row of tables II to V does not meet; none for the
    baseline, of which nothing is asked."""
    if row['matcher'] not in MATCHERS or 'failed' in row:
        return []
    misses = []
    who = name_of(row)
    if not row['translation_mm']['median'] <= MEDIAN_MM:
        misses.append('%s: the median error is %.2f mm, more than %g mm' % (
            who, row['translation_mm']['median'], MEDIAN_MM))
    if not row['heading_mrad']['median'] <= MEDIAN_MRAD:
        misses.append('%s: the median error is %.3f mrad, more than %g mrad' % (
            who, row['heading_mrad']['median'], MEDIAN_MRAD))
    least = least_success(row['test'], row['matcher'])
    if not row['success_rate'] >= least:
        misses.append('%s: %.1f %% of the trials succeed, fewer than %g %%' % (
            who, 100.0 * row['success_rate'], 100.0 * least))
    return misses


def too_slow(who, time, limit):
    return [] if time <= limit else ['%s takes %.2f ms, more than %g ms' % (who, time, limit)]


def time_misses(row):
    """The same of the time, which depends on the machine."""
    limit = TIME_MS.get(row['matcher'])
    if limit is None or 'failed' in row:
        return []
    return too_slow(name_of(row) + ': a match', row['time_ms']['median'], limit)


def budget_misses(row):
    budget = BUDGETS[row['name']]
    return [] if 'failed' in row else too_slow(
        '%s, %s: a match' % (NAMES[budget.matcher], budget.title), row['time_ms']['median'], budget.limit)


def scan_misses(row):
    """Of a row of the maps."""
    return [] if 'failed' in row or row['matcher'] not in MATCHERS else too_slow(
        '%s in figure 6: a scan through map_bag' % NAMES[row['matcher']], row['scan_ms'], SCAN_MS)


def failures(rows, what):
    """Sentences of what has no result."""
    return ['%s: %s' % (what(row), row['failed']) for row in rows if 'failed' in row]
