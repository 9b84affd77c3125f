"""What is asked of a matcher in each test, and whether it does it, in words."""

from experiments import MATCHERS, NAMES, NOISES

MEDIAN_MM = 1.0
MEDIAN_MRAD = 0.5
# Share of trials within 2 cm and 10 mrad, where the guess is wrong.
SUCCESS = 0.99
SUCCESS_OF = {('D', 'hough'): 0.95}
# Median time of a match where the guess is wrong [ms], 1040 beams, on one core.
TIME_MS = {'olson': 2.0, 'monte_carlo': 1.0, 'hough': 1.5}


def least_success(test, matcher):
    return SUCCESS_OF.get((test, matcher), SUCCESS) if test in 'BD' else 0.0


def accuracy_misses(row):
    """Sentences, one for each demand that a row of tables II to V does not meet; none for the
    baseline, of which nothing is asked."""
    if row['matcher'] not in MATCHERS:
        return []
    misses = []
    who = '%s in test %s, range noise %g cm' % (NAMES[row['matcher']], row['test'],
                                                100.0 * NOISES[row['noise']])
    if not row['translation_mm']['median'] <= MEDIAN_MM:
        misses.append('%s: the median error is %.2f mm, more than %g mm' % (
            who, row['translation_mm']['median'], MEDIAN_MM))
    if not row['heading_mrad']['median'] <= MEDIAN_MRAD:
        misses.append('%s: the median error is %.3f mrad, more than %g mrad' % (
            who, row['heading_mrad']['median'], MEDIAN_MRAD))
    least = least_success(row['test'], row['matcher'])
    if not row['success_rate'] >= least:
        misses.append('%s: %.1f %% of the trials end within 2 cm and 10 mrad, fewer than %g %%' % (
            who, 100.0 * row['success_rate'], 100.0 * least))
    return misses


def time_misses(row):
    """The same of the time, which depends on the machine."""
    limit = TIME_MS.get(row['matcher'])
    if limit is None or row['test'] not in 'BD' or row['time_ms']['median'] <= limit:
        return []
    return ['%s in test %s, range noise %g cm: a match takes %.2f ms in the median, more than %g ms' % (
        NAMES[row['matcher']], row['test'], 100.0 * NOISES[row['noise']], row['time_ms']['median'],
        limit)]
