"""Writes the results of a sweep: a CSV for programs and a page for people."""

import collections
import csv
import io
import statistics

from files import Failed, write_text
from html_page import box, document, escape, table
from results import Made, result_of_map
from sweep_cells import text_of
from tables import Row as TableRow
from tables import Table, failed_row, number

# A cell, the folder of its results, its settings, and whether its bag has a truth.
Row = collections.namedtuple('Row', 'folder cell settings has_truth')
COLUMNS = ['bag', 'matcher', 'setting', 'seed', 'scans', 'used', 'ate_rmse_m', 'ate_max_m',
           'heading_rmse_rad', 'odometry_rmse_m', 'occupied_of_known', 'corners', 'enclosed_areas',
           'match_p50_ms', 'match_p95_ms', 'cpu_s', 'host', 'status']
# How the page shows a number; the CSV has all digits.
FORMS = {'ate_rmse_m': '%.4f', 'ate_max_m': '%.4f', 'heading_rmse_rad': '%.5f', 'odometry_rmse_m': '%.4f',
         'occupied_of_known': '%.4f', 'match_p50_ms': '%.3f', 'match_p95_ms': '%.3f', 'cpu_s': '%.1f'}
SHOWN = COLUMNS[:-2]
# Of all seeds together.
MEANS = ['ate_rmse_m', 'heading_rmse_rad', 'occupied_of_known', 'match_p50_ms']


def results(row, made):
    """The results of one cell; its status is ok, or why there are none."""
    cell = row.cell
    found = {'bag': cell.bag, 'matcher': cell.matcher, 'setting': text_of(row.settings), 'seed': cell.seed,
             'status': 'ok'}
    try:
        report, quality, errors = result_of_map(row.folder, cell.matcher, cell.seed, row.has_truth)
    except Failed as failure:
        return dict(found, status='failed: %s' % failure)
    made.add(report)
    found.update(scans=report['scans']['received'], used=report['scans']['used'],
                 match_p50_ms=report['match_ms']['p50'], match_p95_ms=report['match_ms']['p95'],
                 cpu_s=report['cpu_s'], host=report['machine']['host'])
    found.update({key: quality[key] for key in ('occupied_of_known', 'corners', 'enclosed_areas')})
    if errors:
        own, *odometry = errors
        found.update(ate_rmse_m=own['rmse_m'], ate_max_m=own['max_m'], heading_rmse_rad=own['heading_rmse_rad'])
        found.update({'odometry_rmse_m': estimate['rmse_m'] for estimate in odometry})
    return found


def spread(values, form):
    """Mean and, of more than one, standard deviation."""
    if not values:
        return '–'
    text = form % statistics.mean(values)
    return text + ' ± ' + form % statistics.stdev(values) if len(values) > 1 else text


def aggregate(found):
    """One row for all seeds of a bag, matcher and setting; the best error against the truth comes first."""
    groups = {}
    for row in found:
        groups.setdefault((row['bag'], row['matcher'], row['setting']), []).append(row)
    bags = list(dict.fromkeys(row['bag'] for row in found))

    def error(group):
        errors = [row['ate_rmse_m'] for row in groups[group] if 'ate_rmse_m' in row]
        return bags.index(group[0]), statistics.mean(errors) if errors else float('inf')
    return Table(['bag', 'matcher', 'setting', 'seeds\ndone'] + [name.replace('_', '\n') for name in MEANS], [
        TableRow('', list(group) + [
            '%d of %d' % (sum(row['status'] == 'ok' for row in groups[group]), len(groups[group]))] + [
                spread([row[name] for row in groups[group] if name in row], FORMS[name]) for name in MEANS])
        for group in sorted(groups, key=error)])


def single(found):
    """One row a map."""
    return Table([column.replace('_', '\n') for column in SHOWN], [
        TableRow('', [str(number(row.get(column), FORMS.get(column, '%s'))) for column in SHOWN])
        if row['status'] == 'ok' else
        failed_row('%s, %s, %s, seed %s' % (row['bag'], row['matcher'], row['setting'], row['seed']),
                   row['status'].partition(': ')[2]) for row in found])


def write(rows, table_path, page_path):
    made = Made()
    found = [results(row, made) for row in rows]
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, restval='', lineterminator='\n')
    writer.writeheader()
    writer.writerows(found)
    failed = sum(row['status'] != 'ok' for row in found)
    lines = ['<p class="facts">matchbox_slam %s, commit %s. Run on %s. Errors (ATE) are of the trajectory after '
             'alignment to the truth, where there is one. Times are those that the program had on a processor.</p>' %
             tuple(map(escape, (', '.join(sorted(made.versions)), ', '.join(sorted(made.commits)) or 'unknown',
                                '; '.join(made.places()) or 'no machine')))]
    if failed:
        lines.append(box(False, '%d of %d maps failed; their rows say why.' % (failed, len(found))))
    lines += ['<h2>All seeds together</h2>',
              '<p>Mean ± standard deviation; of each bag the least error against the truth comes first.</p>',
              table(aggregate(found), 'words'), '<h2>Every map</h2>', table(single(found), 'words')]
    write_text(table_path, text.getvalue())
    write_text(page_path, document('Sweep', '\n'.join(lines)))
