#!/usr/bin/env python3
"""Writes, in the folder of a run, index.html: one page of all results, with its pictures inside; and tables.md,
the same tables in Markdown."""

import argparse
import math
import os
import re

import html_page
import markdown
import tables
import verdicts
from experiments import BASELINE, FAR, FOUND, HARD_ERROR, NAMES, TESTS
from files import read_json, reason, write_text
from html_page import box, escape, figure
from tables import Row, Table


def indexed(text):
    """n_x as n with an index."""
    return re.sub(r'\bn_(\w)', r'n<sub>\1</sub>', escape(text))


def picture(name, caption, wide=False, log=None):
    """A figure of the run; where it is missing, the log says why."""
    return figure(os.path.join('figures', name + '.png'), caption,
                  reason(os.path.join('figures', (log or name) + '.log')), wide)


def first_of(summary, key):
    """A figure that all rows of tables II to V share, of one that did not fail."""
    return next((row[key] for row in summary['tests'] if key in row), None)


def success_text(summary):
    about = summary['about']
    return 'within %g cm and %g mrad of the truth' % (
        100 * about['success_xy_m'], 1000 * about['success_theta_rad'])


def verdict(title, misses, praise):
    return box(False, title, misses) if misses else box(True, praise)


def accuracy_verdict(summary):
    asked = ('asked of each matcher: a median error of at most %g mm and %g mrad; in tests B and D also '
             'success in at least %g %% of the trials (Hough in D: %g %%)' % (
                 verdicts.MEDIAN_MM, verdicts.MEDIAN_MRAD, 100 * verdicts.SUCCESS,
                 100 * verdicts.least_success('D', 'hough')))
    return verdict('Not accurate enough (%s):' % asked, summary['missed'],
                   'Every matcher that was measured is as accurate as %s. This holds with and without noise.' % asked)


def speed_verdict(times):
    limits = ', '.join('%s %g ms' % (NAMES[name], limit) for name, limit in verdicts.TIME_MS.items())
    asked = ('asked, in the median: %s in all four tests; of Olson for the windows below; a scan through map_bag '
             '%g ms' % (limits, verdicts.SCAN_MS))
    return verdict('Slower on this machine than %s:' % asked, times['missed'],
                   'Everything that was measured is as fast as %s.' % asked)


def tests_section(summary, times):
    about = summary['about']
    lines = ['<h2>Tables II to V: error and time of scan matching</h2>', accuracy_verdict(summary),
             speed_verdict(times), '<p>Not measured here: %s.</p>' % escape(verdicts.NOT_MEASURED)]
    if about:
        lines.append(
            '<p>%d trials a row: pairs of scans %.2g s apart, %d beams, %g cm cells. The guess is the true motion '
            'plus an error drawn uniformly. Success is to end %s. Times are those that a match had on a processor. '
            '“Noise” is the standard deviation of the simulated laser’s ranges; the paper does not name its own. '
            '|Δx|, |Δy|: ahead and aside, in the frame of the robot. The paper gives one figure a cell, without '
            'noise, beams, trials or search windows, on a Core i7-860; its Hough matcher finds no translation. All '
            'three matchers here end in the same refinement, which none of the paper’s has: to be compared with the '
            'paper’s are the last three columns, where the searches ended before it.</p>' % (
                first_of(summary, 'pairs'), about['gap_s'], about['beams'],
                100 * next(iter(summary['configurations'].values()))['map/resolution'], success_text(summary)))
    for name, test in TESTS.items():
        lines += ['<h3>Table %s: test %s, %s</h3>' % (test.table, name, escape(test.title)),
                  html_page.table(tables.test_table(name, summary, times))]
    return '\n'.join(lines + [
        '<h3>Olson’s search of a given window</h3>',
        '<p>In the tables the window follows from the uncertainty of the guess: %s standard deviations to each side, '
        'which is another one than the ±0.2 m and ±0.2 rad for which a time is asked. Here the window is exactly '
        'that, and that of a loop closure; straight world, range noise 1 cm.</p>' %
        summary['configurations'].get('olson', {}).get('olson/window_sigmas', 'some'),
        html_page.table(tables.budget_table(times))])


def search_section(times):
    return '\n'.join([
        '<h2>The searches alone</h2>',
        '<p>Times of the searches without the refinement that all three end in, of the pairs of tests B and D with range '
        'noise 1 cm; their errors are in the last columns of tables III and V.</p>',
        html_page.table(tables.search_table(times))])


def found_text():
    return 'a match is believed and ends within %g cm and %.2g° of the truth' % (100 * FOUND[0], math.degrees(FOUND[1]))


def basin_section(summary, times):
    return '\n'.join([
        '<h2>Beyond the basin: how wrong may the guess be?</h2>',
        '<p>The guess is off by anything up to %g m, in any direction, and by as large a share of %g°, to either side. '
        'Found: %s. The windows of Olson and Hough, and the spread of Monte-Carlo’s draws, follow from what the matchers '
        'are told that the guess may be off by: once as little as in tests B and D, once as much as it is. Range noise '
        '1 cm.</p>' % (FAR[0], math.degrees(FAR[1]), found_text()),
        '<div class="figures">', picture('basins', 'Success against the error of the guess. Dashed: where the search '
                                         'ended; solid: refined.', wide=True), '</div>',
        html_page.table(tables.basin_table(summary, times))])


def hard_section(summary, times):
    return '\n'.join([
        '<h2>Worse scans: which matcher when?</h2>',
        '<p>Fewer beams, more noise, and beams that end on something small anywhere before the wall. The guess is off by '
        'up to %g m and %g rad, and the matchers are told so. Found: %s.</p>' % (HARD_ERROR + (found_text(),)),
        html_page.table(tables.hard_table(summary, times))])


def complexity_section(times):
    return '\n'.join([
        '<h2>Table I: complexity, measured</h2>',
        '<p>One quantity grows, all else stays; t = a + b·x<sup>k</sup> is fitted to the median times. The paper’s '
        'orders are products of first powers: an exponent k of 1 agrees, a smaller one is better. The interval holds '
        '90 %% of the fits to trials drawn anew; where it is wider than %g, the times do not tell the exponent, and '
        'none is given. Straight world, range noise 1 cm, guesses off by up to 0.1 m and 0.1 rad.</p>' %
        tables.WIDEST_INTERVAL,
        html_page.table(tables.complexity_table(times), 'words', indexed),
        '<div class="figures">', picture('1_complexity', 'Times of table I, and the fits. Both axes are '
                                         'logarithmic.', wide=True), '</div>'])


SCAN_CAPTIONS = [
    ('2_scan', 'Figure 2: a scan of the recording, and the robot.'),
    ('3_lookup_table', 'Figure 3: the idea of the lookup table: a Gaussian around each point of a reference scan, as '
                       'wide as in the configuration (field/sigma), and a later scan over it: from a prediction that '
                       'is off, and where the trajectory by Olson puts it. Drawn from the bag; Olson’s own table '
                       'is of the map.'),
    ('4_hough_lines', 'Figure 4: lines through a point are a sinusoid of ρ and θ; the sinusoids of points on '
                      'one wall meet in that wall. Drawn from the scan of figure 2.'),
    ('5_hough_domain', 'Figure 5: the idea of the Hough domain, of that scan: cells of 3 cm and 1°, one vote a point, '
                       'and its spectrum. Drawn from the bag; the matcher weights votes by the piece of wall that a '
                       'point stands for, which map_bag --debug draws. The colours end at a third of the most '
                       'votes, so that weak lines show.'),
]


def map_caption(letter, row):
    text = 'Figure 6%s: the map by %s.' % (letter, NAMES[row['matcher']])
    if 'failed' in row:
        return text
    quality = row['quality']
    return text + ' Occupied %.2f %% of the known cells, %d corners, %d enclosed areas.' % (
        100 * quality['occupied_of_known'], quality['corners'], quality['enclosed_areas'])


def trajectory_caption(number, row, has_truth):
    text = 'Figure %d: the trajectory by %s' % (number, NAMES[row['matcher']])
    if not has_truth:
        return text + ' over odometry. The recording came without a truth.'
    return text + ' over odometry and truth, all aligned to the truth; below, the errors in the course of time.'


def maps_section(summary, times):
    by_name = {row['matcher']: row for row in summary['maps']}
    has_truth = summary['options']['has_truth']
    # The paper's order.
    order = [BASELINE, 'hough', 'olson', 'monte_carlo']
    return '\n'.join(
        ['<h2>Figures 6 to 9: one recording, four maps</h2>',
         '<p>Recording: %s. Walls drawn twice, or smeared, raise the three figures of quality (Filatov et al. '
         '2017): less is better among maps that look right. Maps that forget, as these do, hide doubled walls, '
         'so a map that is plainly wrong may have low figures too: look first. Times are those on a '
         'processor.</p>' %
         escape(', '.join(summary['options']['bags'])), html_page.table(tables.map_table(summary, times)),
         '<div class="figures">'] +
        [picture('map_' + name, map_caption(letter, by_name[name]), log='maps')
         for letter, name in zip('abcd', order)] +
        [picture('trajectory_' + name, trajectory_caption(number, by_name[name], has_truth))
         for number, name in enumerate(order[1:], start=7)] + ['</div>'])


def configuration_table(configuration):
    return html_page.table(Table(['parameter', 'value'], [
        Row('', [key, str(value)]) for key, value in sorted(configuration.items())]), 'words')


def details(title, content):
    return '<details><summary>%s</summary>%s</details>' % (escape(title), content)


def configuration_section(summary, times):
    lines = ['<h2>Configuration</h2>', '<p>What each matcher ran with, defaults included. Table I and the given '
             'windows change what the command lines below set.</p>']
    lines += [details(NAMES[matcher] + ', tables II to V', configuration_table(configuration))
              for matcher, configuration in summary['configurations'].items()]
    for matcher, changed in summary['map_configurations'].items():
        title = '%s, figures 6 to 9: ' % NAMES[matcher]
        lines.append(details(title + 'what differs from tables II to V', configuration_table(changed))
                     if changed else '<p>%sas in tables II to V.</p>' % escape(title))
    lines.append(details('Command lines', '<pre class="scroll">%s</pre>' % escape('\n'.join(times['commands']))))
    return '\n'.join(lines)


def facts(summary, times):
    options = summary['options']
    given = ', '.join('%s=%s' % item for item in options['settings'].items()) or 'none, all defaults'
    programs = ', '.join('%s %s' % item for item in times['programs'].items())
    lines = ['<p class="facts">matchbox_slam %s, commit %s. Size %s, seed %s of worlds, noise, pairs, guesses and '
             'matchers. Parameters given: %s. Run on %s. Fingerprints of the programs: %s.</p>' % tuple(map(escape, (
                 summary['version'], summary['commit'] or 'unknown', options['size'], options['seed'], given,
                 '; '.join(times['machines']) or 'no machine', programs)))]
    if options['size'] == 'quick':
        lines.append(box(False, 'A quick run: fewer trials and shorter recordings than the experiments ask for. '
                                'The figures are rough.'))
    if summary['failed']:
        lines.append(box(False, 'What failed:', summary['failed']))
    return '\n'.join(lines)


def page(summary, times):
    quick = ' (quick)' if summary['options']['size'] == 'quick' else ''
    return html_page.document('The scan matchers compared' + quick, '\n'.join([
        '<p>The experiments of <cite>The Scan Matchers Research and Comparison: Monte-Carlo, Olson and '
        'Hough</cite>, made anew.</p>', facts(summary, times), tests_section(summary, times),
        search_section(times), basin_section(summary, times), hard_section(summary, times), complexity_section(times), '<h2>Figures 2 to 5: how the matchers see a scan</h2>',
        '<div class="figures">'] + [picture(name, caption, wide=name[0] in '45', log='scans')
                                    for name, caption in SCAN_CAPTIONS] +
        ['</div>', maps_section(summary, times), configuration_section(summary, times)]))


def main():
    argparse.ArgumentParser(description=__doc__).parse_args()
    summary, times = read_json('summary.json'), read_json('times.json')
    write_text('tables.md', markdown.document(summary, times))
    write_text('index.html', page(summary, times))


if __name__ == '__main__':
    main()
