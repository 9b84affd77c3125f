"""The tables of a run, for the page and for Markdown: text alone, with a line break before each further line
of a heading."""

import collections

from experiments import BASELINE, BASIN_BINS, BASINS, BUDGETS, FAR, HARD, MATCHERS, NAMES, NOISES, PAPER

# kind: '' or 'paper' or 'failed'; a failed row has two cells: what failed, and why.
Row = collections.namedtuple('Row', 'kind cells')
Table = collections.namedtuple('Table', 'header rows')
# How much of an exponent's interval is too much to tell the exponent.
WIDEST_INTERVAL = 0.3


def number(value, form):
    return '–' if value is None else form % value


def failed_row(label, reason):
    return Row('failed', [label, 'failed: ' + reason])


def milli(value):
    return '–' if value is None else '%g' % (1000.0 * value)


def paper_row(test, matcher):
    """The paper's single figures, in the columns of ours."""
    time, x, y, heading = PAPER[test][matcher]
    return Row('paper', [NAMES[matcher] + ', the paper', milli(time), '', '', milli(x), milli(y), '', '',
                         milli(heading), '', '', '', '', ''])


def own_row(label, row, time):
    if 'failed' in row:
        return failed_row(label, row['failed'])
    return Row('', [label, '%.3f' % time['median'], '%.3f' % time['p95'], '%.3f' % time['max'],
                    '%.3f' % row['median_x_mm'], '%.3f' % row['median_y_mm'],
                    '%.2f' % row['translation_mm']['median'], '%.2f' % row['translation_mm']['p95'],
                    '%.3f' % row['heading_mrad']['median'], '%.3f' % row['heading_mrad']['p95'],
                    '%.1f' % (100.0 * row['success_rate']), '%.2f' % row['search']['mm'],
                    '%.3f' % row['search']['mrad'], '%.1f' % (100.0 * row['search']['success_rate'])])


def test_table(name, summary, times):
    """One of tables II to V."""
    own = {(row['test'], row['noise'], row['matcher']): row for row in summary['tests']}
    time_of = {(row['test'], row['noise'], row['matcher']): row.get('time_ms') for row in times['tests']}
    rows = []
    for matcher in list(MATCHERS) + [BASELINE]:
        if matcher in PAPER[name]:
            rows.append(paper_row(name, matcher))
        for noise, deviation in NOISES.items():
            key = (name, noise, matcher)
            rows.append(own_row('%s, noise %g cm' % (NAMES[matcher], 100.0 * deviation), own[key], time_of[key]))
    return Table(['matcher', 'time ms,\nmedian', '\n95 %', '\nmost', '|Δx| mm,\nmedian', '|Δy| mm,\nmedian',
                  'error mm,\nmedian', '\n95 %', '|Δθ| mrad,\nmedian', '\n95 %', 'success\n%',
                  'search alone: mm,\nmedian', 'mrad,\nmedian', 'success\n%'], rows)


def exponent(fit):
    """The exponent with its interval; none where that is so wide that it says nothing."""
    low, high = fit['interval']
    return '–' if high - low > WIDEST_INTERVAL else '%.2f (%.2f to %.2f)' % (fit['exponent'], low, high)


def complexity_row(row):
    label = '%s: O(%s)' % (NAMES[row['matcher']], row['paper'])
    if 'failed' in row:
        return failed_row(label, row['failed'])
    return Row('', [label, row['quantity'], row['how'], '{:,}'.format(row['x'][0]), '{:,}'.format(row['x'][-1]),
                    '%.2f to %.2f' % (row['time_ms'][0], row['time_ms'][-1]), exponent(row['fit']),
                    '%.2f' % row['fit']['fixed'], '%.1f %%' % (100 * row['fit']['deviation'])])


def complexity_table(times):
    """Table I."""
    return Table(['matcher: the paper', 'against', 'which is', 'from', 'to', 'time ms', 'exponent k\n(90 % interval)',
                  'fixed a,\nms', 'deviation\nof the fit'], [complexity_row(row) for row in times['complexity']])


def budget_row(row):
    budget = BUDGETS[row['name']]
    label = '%s, %s' % (NAMES[budget.matcher], budget.title)
    if 'failed' in row:
        return failed_row(label, row['failed'])
    return Row('', [label, '±%g m, ±%g rad' % budget.error, '%.3f' % row['time_ms']['median'],
                    '%.3f' % row['time_ms']['p95'], '%g' % budget.limit, '%.1f' % (100.0 * row['success_rate'])])


def budget_table(times):
    return Table(['window', 'guess off by', 'time ms,\nmedian', '\n95 %', 'asked', 'success\n%'],
                 [budget_row(row) for row in times['budgets']])


def map_row(row, time, error):
    label = NAMES[row['matcher']]
    if 'failed' in row:
        return failed_row(label, row['failed'])
    quality, heading = row['quality'], error.get('heading_rmse_rad')
    return Row('', [label, '%d of %d' % (row['used'], row['scans']), '%.2f' % (100 * quality['occupied_of_known']),
                    str(quality['corners']), str(quality['enclosed_areas']), number(error.get('rmse_m'), '%.4f'),
                    number(error.get('median_m'), '%.4f'), number(error.get('max_m'), '%.4f'),
                    '–' if heading is None else '%.2f' % (1000 * heading), '%.3f' % time['match_ms']['p50'],
                    '%.3f' % time['match_ms']['p95'], '%.2f' % time['scan_ms']])


def map_table(summary, times):
    """Of figure 6."""
    time_of = {row['matcher']: row for row in times['maps']}
    # The odometry's error stands in the rows of all matchers.
    odometry = next((row['odometry'] for row in summary['maps'] if 'odometry' in row), {})
    return Table(['matcher', 'scans used', 'occupied of\nknown %', 'corners', 'enclosed\nareas',
                  'position m,\nrms error', '\nmedian', '\nmost', 'heading mrad,\nrms error', 'match ms,\nmedian',
                  '\n95 %', 'a scan through\nmap_bag, ms'],
                 [map_row(row, time_of[row['matcher']],
                          row.get('trajectory', odometry if row['matcher'] == BASELINE else {}))
                  for row in summary['maps']])


def by_cell(rows):
    return {(row['name'], row['matcher']): row for row in rows}


def search_table(times):
    """Times of the searches without the refinement that all end in, beside those with it."""
    with_refinement = {(row['test'], row['matcher']): row.get('time_ms') for row in times['tests']
                       if row['noise'] == '1cm'}
    rows = []
    for (test, matcher), row in by_cell(times['searches']).items():
        label, whole = '%s, test %s' % (NAMES[matcher], test), with_refinement[(test, matcher)]
        rows.append(failed_row(label, row['failed']) if 'failed' in row else Row('', [
            label, '%.3f' % row['time_ms']['median'], '%.3f' % row['time_ms']['p95'],
            '–' if whole is None else '%.3f' % whole['median'], '–' if whole is None else '%.3f' % whole['p95']]))
    return Table(['matcher', 'search alone: ms,\nmedian', '\n95 %', 'refined: ms,\nmedian', '\n95 %'], rows)


def percent(share):
    # 100 only where nothing is missing.
    return '%.0f' % min(100.0 * share, 99.0 if share < 1.0 else 100.0)


def found_cell(found):
    """The own answers, and the refined ones."""
    return '–' if found is None else '%s / %s' % (percent(found['search']), percent(found['answer']))


def basin_table(summary, times):
    """Success by the error of the guess."""
    time_of, rows = by_cell(times['basins']), []
    for (name, matcher), row in by_cell(summary['basins']).items():
        label = '%s: %s' % (BASINS[name].title, NAMES[matcher])
        rows.append(failed_row(label, row['failed']) if 'failed' in row else Row('', (
            [label] + list(map(found_cell, row['found'])) + ['%.2f' % time_of[(name, matcher)]['time_ms']['median']])))
    bounds = ['%g' % (FAR[0] * (i + 1) / BASIN_BINS) for i in range(BASIN_BINS)]
    return Table(['found % by the search alone / refined,\nof guesses off by up to'] +
                 [bound + ' m' for bound in bounds] + ['time ms,\nmedian'], rows)


def hard_label(hard):
    return '%s, %d beams, noise %g cm, outliers %g %%' % (
        {'rooms': 'straight', 'random': 'random'}[hard.world], hard.beams, 100.0 * hard.noise, 100.0 * hard.outliers)


def hard_table(summary, times):
    """Which matcher still finds its way in worse scans."""
    time_of, rows = by_cell(times['hard']), []
    for (name, matcher), row in by_cell(summary['hard']).items():
        label = '%s: %s' % (hard_label(HARD[name]), NAMES[matcher])
        rows.append(failed_row(label, row['failed']) if 'failed' in row else Row('', [
            label, found_cell(row['found']), '%.1f / %.2f' % (row['search_mm_mrad'][0], row['answer_mm_mrad'][0]),
            '%.2f / %.3f' % (row['search_mm_mrad'][1], row['answer_mm_mrad'][1]),
            '%.2f' % time_of[(name, matcher)]['time_ms']['median']]))
    return Table(['scans', 'found %,\nsearch alone / refined', 'error mm, median,\nsearch alone / refined',
                  'mrad, median,\nsearch alone / refined', 'time ms,\nmedian'], rows)
