#!/usr/bin/env python3
"""Writes one HTML page of all results, with its pictures inside, that needs nothing else to be read."""

import argparse
import base64
import html
import os
import re

import verdicts
from experiments import BASELINE, MATCHERS, NAMES, NOISES, PAPER, TESTS
from files import read_json, write_text


def escape(value):
    return html.escape(str(value))


def table(header, rows, name=''):
    """Rows are (class or None, cells); cells are HTML."""
    lines = ['<div class="scroll"><table class="%s"><thead><tr>' % name]
    lines += ['<th>%s</th>' % cell for cell in header] + ['</tr></thead><tbody>']
    for name, cells in rows:
        lines.append('<tr%s>' % (' class="%s"' % name if name else ''))
        lines += ['<td>%s</td>' % cell for cell in cells] + ['</tr>']
    return '\n'.join(lines + ['</tbody></table></div>'])


def figure(folder, name, caption, wide=False):
    with open(os.path.join(folder, name + '.png'), 'rb') as file:
        picture = base64.b64encode(file.read()).decode()
    return ('<figure%s><div class="scroll"><img alt="%s" src="data:image/png;base64,%s"></div>'
            '<figcaption>%s</figcaption></figure>' % (
                ' class="wide"' if wide else '', escape(caption), picture, escape(caption)))


def indexed(formula):
    """n_x as n with an index."""
    return re.sub(r'_(\w)', r'<sub>\1</sub>', escape(formula))


def verdict(title, misses, praise):
    if not misses:
        return '<div class="good">%s</div>' % escape(praise)
    return '<div class="bad">%s<ul>%s</ul></div>' % (
        escape(title), ''.join('<li>%s.</li>' % escape(miss) for miss in misses))


def number(value, form):
    return '–' if value is None else form % value


def paper_cells(figures):
    """A row of ours, filled with the paper's single figures."""
    time, x, y, heading = figures
    return ['%g' % (1000.0 * time), '', '',
            number(x, '%g') if x is None else '%g' % (1000.0 * x),
            number(y, '%g') if y is None else '%g' % (1000.0 * y),
            '', '', '%g' % (1000.0 * heading), '', '']


def own_cells(row, time):
    return ['%.3f' % time['median'], '%.3f' % time['p95'], '%.3f' % time['max'],
            '%.3f' % row['median_x_mm'], '%.3f' % row['median_y_mm'],
            '%.2f' % row['translation_mm']['median'], '%.2f' % row['translation_mm']['p95'],
            '%.3f' % row['heading_mrad']['median'], '%.3f' % row['heading_mrad']['p95'],
            '%.1f' % (100.0 * row['success_rate'])]


def test_table(name, summary, times):
    header = ['matcher', 'time ms,<br>median', '<br>95 %', '<br>most', '|Δx| mm,<br>median',
              '|Δy| mm,<br>median', 'error mm,<br>median', '<br>95 %', '|Δθ| mrad,<br>median',
              '<br>95 %', 'success<br>%']
    own = {(row['test'], row['noise'], row['matcher']): row for row in summary['tests']}
    time_of = {(row['test'], row['noise'], row['matcher']): row['time_ms'] for row in times['tests']}
    rows = []
    for matcher in list(MATCHERS) + [BASELINE]:
        if matcher in PAPER[name]:
            rows.append(('paper', [NAMES[matcher] + ', the paper'] + paper_cells(PAPER[name][matcher])))
        for noise, deviation in NOISES.items():
            key = (name, noise, matcher)
            label = '%s, noise %g cm' % (NAMES[matcher], 100.0 * deviation)
            rows.append((None, [label] + own_cells(own[key], time_of[key])))
    return '<h3>Table %s: test %s, %s</h3>\n%s' % (
        TESTS[name].table, name, escape(TESTS[name].title), table(header, rows))


def tests_section(summary, times):
    pairs = summary['tests'][0]['pairs']
    asked = ('asked of each matcher: a median error of at most %g mm and %g mrad; in tests B and D also '
             'success in at least %g %% of the trials (Hough in D: %g %%)' % (
                 verdicts.MEDIAN_MM, verdicts.MEDIAN_MRAD, 100 * verdicts.SUCCESS,
                 100 * verdicts.least_success('D', 'hough')))
    limits = ', '.join('%s %g ms' % (NAMES[name], limit) for name, limit in verdicts.TIME_MS.items())
    return '\n'.join([
        '<h2>Tables II to V: error and time of scan matching</h2>',
        verdict('Not accurate enough (%s):' % asked, summary['missed'],
                'Every matcher is as accurate as %s. This holds with and without noise.' % asked),
        verdict('Slower on this machine than asked in tests B and D (median: %s):' % limits,
                times['missed'], 'Every matcher is as fast as asked in tests B and D (median: %s).' % limits),
        '<p>%d trials a row: pairs of scans half a second apart, 1040 beams over 260°, 5 cm cells. The guess '
        'is the true motion plus an error drawn uniformly. Success is to end within 2 cm and 10 mrad of the '
        'truth. Times are those that a match had on a processor. “Noise” is the standard deviation of the '
        'simulated laser’s ranges; the paper does not name its own. |Δx|, |Δy|: ahead and aside, in the frame of '
        'the robot. The paper gives one figure a cell, without noise, beams, trials or search windows, on a '
        'Core i7-860; its Hough matcher finds no translation.</p>' % pairs] +
        [test_table(name, summary, times) for name in TESTS])


def complexity_section(times, figures):
    header = ['matcher', 'the paper', 'against', 'from', 'to', 'exponent<br>of t = a + b·x^k', 'fixed a, ms',
              'deviation<br>of the fit', 'slope of<br>log t, log x']
    rows = [(None, [NAMES[row['matcher']], 'O(%s)' % indexed(row['paper']),
                    '%s: %s' % (indexed(row['quantity']), escape(row['how'])), '{:,}'.format(row['x'][0]),
                    '{:,}'.format(row['x'][-1]), '%.2f' % row['fit']['exponent'],
                    '%.2f' % row['fit']['fixed'], '%.1f %%' % (100 * row['fit']['deviation']),
                    '%.2f' % row['fit']['loglog']]) for row in times['complexity']]
    return '\n'.join([
        '<h2>Table I: complexity, measured</h2>',
        '<p>One quantity grows, all else stays. The paper’s orders are products of first powers: an exponent '
        'of 1 agrees, a smaller one is better. Where the fixed cost a is most of the time, the exponent is '
        'not well known. Median times of matches in the straight world, range noise '
        '1 cm, guesses off by up to 0.1 m and 0.1 rad.</p>',
        table(header, rows, 'words'),
        '<div class="figures">', figure(figures, '1_complexity', 'Times of table I, and the fits. Both '
                                        'axes are logarithmic.', wide=True), '</div>'])


SCAN_CAPTIONS = [
    ('2_scan', 'Figure 2: a scan of the recording, and the robot.'),
    ('3_lookup_table', 'Figure 3: the lookup table of a reference scan, and a later scan over it: from a '
                       'prediction that is off, and where the trajectory by Olson puts it. Drawn from the bag: '
                       'the table here is a Gaussian around each point, as wide as in the configuration '
                       '(field/sigma).'),
    ('4_hough_lines', 'Figure 4: lines through a point are a sinusoid of ρ and θ; the sinusoids of points on '
                      'one wall meet in that wall. Drawn from the scan of figure 2.'),
    ('5_hough_domain', 'Figure 5: the Hough domain of that scan (3 cm, 1°, one vote a point) and its spectrum. '
                       'The colours end at a third of the most votes, so that weak lines show.'),
]


def map_caption(letter, row):
    quality = row['quality']
    text = 'Figure 6%s: the map by %s. Occupied %.2f %% of the known cells, %d corners, %d enclosed areas.' % (
        letter, NAMES[row['matcher']], 100 * quality['occupied_of_known'], quality['corners'],
        quality['enclosed_areas'])
    return text


def trajectory_caption(number, row, has_truth):
    text = 'Figure %d: the trajectory by %s' % (number, NAMES[row['matcher']])
    if not has_truth:
        return text + ' over odometry. The recording came without a truth.'
    return text + ' over odometry and truth, all aligned to the truth; below, the errors in the course of time.'


def maps_table(summary, times):
    header = ['matcher', 'scans used', 'occupied of<br>known %', 'corners', 'enclosed<br>areas',
              'position m,<br>rms error', '<br>median', '<br>most', 'heading mrad,<br>rms error',
              'match ms,<br>median', '<br>95 %', 'times<br>real time']
    time_of = {row['matcher']: row for row in times['maps']}
    # The odometry's error stands in the rows of all matchers.
    odometry = next((row['odometry'] for row in summary['maps'] if 'odometry' in row), None)
    rows = []
    for row in summary['maps']:
        error = row.get('trajectory') or (odometry if row['matcher'] == BASELINE else None) or {}
        time, quality = time_of[row['matcher']], row['quality']
        heading = error.get('heading_rmse_rad')
        rows.append((None, [
            NAMES[row['matcher']], '%d of %d' % (row['used'], row['scans']),
            '%.2f' % (100 * quality['occupied_of_known']), str(quality['corners']),
            str(quality['enclosed_areas']), number(error.get('rmse_m'), '%.4f'),
            number(error.get('median_m'), '%.4f'), number(error.get('max_m'), '%.4f'),
            '–' if heading is None else '%.2f' % (1000 * heading), '%.3f' % time['match_ms']['p50'],
            '%.3f' % time['match_ms']['p95'], '%.0f' % time['real_time_factor']]))
    return table(header, rows)


def maps_section(summary, times, figures):
    by_name = {row['matcher']: row for row in summary['maps']}
    has_truth = summary['options']['has_truth']
    # The paper's order.
    order = [BASELINE, 'hough', 'olson', 'monte_carlo']
    return '\n'.join(
        ['<h2>Figures 6 to 9: one recording, four maps</h2>',
         '<p>Recording: %s. Walls drawn twice, or smeared, raise the three figures of quality (Filatov et al. '
         '2017): less is better among maps that look right. Maps that forget, as these do, hide doubled walls, '
         'so a map that is plainly wrong may have low figures too: look first.</p>' %
         escape(', '.join(summary['options']['bags'])), maps_table(summary, times), '<div class="figures">'] +
        [figure(figures, 'map_' + name, map_caption(letter, by_name[name]))
         for letter, name in zip('abcd', order)] +
        [figure(figures, 'trajectory_' + name, trajectory_caption(number, by_name[name], has_truth))
         for number, name in enumerate(order[1:], start=7)] + ['</div>'])


def configuration_section(summary):
    lines = ['<h2>Configuration</h2>', '<p>What each matcher ran with, in tables II to V; defaults included. '
             'Table I changes what its rows name.</p>']
    for matcher, configuration in summary['configurations'].items():
        rows = [(None, [escape(key), escape(value)]) for key, value in sorted(configuration.items())]
        lines.append('<details><summary>%s</summary>%s</details>' % (
            NAMES[matcher], table(['parameter', 'value'], rows, 'words')))
    return '\n'.join(lines)


def facts(summary, times):
    settings = summary['options']['settings']
    given = ', '.join('%s=%s' % item for item in settings.items()) or 'none, all defaults'
    commit = summary['commit'] or 'unknown: not run from a git clone'
    return ('<p class="facts">matchbox_slam %s, commit %s, programs %s. Run on %s, %s. Size %s, seed %s of '
            'worlds, noise, pairs, guesses and matchers. Parameters given: %s.</p>' % tuple(map(escape, (
                summary['version'], commit, summary['programs'], times['date'], times['machine'],
                summary['options']['size'], summary['options']['seed'], given))))


def document(title, body):
    """A page that needs no other file."""
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), 'page.css')) as file:
        style = file.read()
    return ('<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n<meta name="viewport" '
            'content="width=device-width, initial-scale=1">\n<title>%s</title>\n'
            '<style>\n%s</style></head>\n<body>\n<h1>%s</h1>\n%s\n</body></html>\n' % (
                escape(title), style, escape(title), body))


def page(summary, times, figures):
    return document('The scan matchers compared', '\n'.join([
        '<p>The experiments of <cite>The Scan Matchers Research and Comparison: Monte-Carlo, Olson and '
        'Hough</cite>, made anew.</p>', facts(summary, times), tests_section(summary, times),
        complexity_section(times, figures), '<h2>Figures 2 to 5: how the matchers see a scan</h2>',
        '<div class="figures">'] + [figure(figures, name, caption, wide=name[0] in '45')
                                    for name, caption in SCAN_CAPTIONS] +
        ['</div>', maps_section(summary, times, figures), configuration_section(summary)]))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--summary', required=True)
    parser.add_argument('--times', required=True)
    parser.add_argument('--figures', required=True, help='folder')
    parser.add_argument('--out', required=True)
    arguments = parser.parse_args()
    write_text(arguments.out, page(read_json(arguments.summary), read_json(arguments.times),
                                   arguments.figures))


if __name__ == '__main__':
    main()
