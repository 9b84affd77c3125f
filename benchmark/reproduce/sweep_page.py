"""Writes the results of a sweep: a CSV for programs and a page for people."""

import csv
import io
import os

from files import read_json, write_text
from page import document, escape, number, table

COLUMNS = ['bag', 'matcher', 'setting', 'seed', 'scans', 'used', 'ate_rmse_m', 'ate_max_m',
           'heading_rmse_rad', 'odometry_rmse_m', 'occupied_of_known', 'corners', 'enclosed_areas',
           'match_p50_ms', 'match_p95_ms', 'cpu_s']
# How the page shows a number; the CSV has all digits.
FORMS = {'ate_rmse_m': '%.4f', 'ate_max_m': '%.4f', 'heading_rmse_rad': '%.5f', 'odometry_rmse_m': '%.4f',
         'occupied_of_known': '%.4f', 'match_p50_ms': '%.3f', 'match_p95_ms': '%.3f', 'cpu_s': '%.1f'}


def row_of(folder):
    """The results of one cell; its folder is named after it."""
    _, bag, matcher, setting, seed = folder.rstrip('/').split('/')
    report = read_json(os.path.join(folder, 'report.json'))
    quality = read_json(os.path.join(folder, 'quality.json'))['maps'][0]
    row = {'bag': bag, 'matcher': matcher, 'setting': setting, 'seed': seed,
           'scans': report['scans']['received'], 'used': report['scans']['used'],
           'match_p50_ms': report['match_ms']['p50'], 'match_p95_ms': report['match_ms']['p95'],
           'cpu_s': report['cpu_s']}
    row.update({key: quality[key] for key in ('occupied_of_known', 'corners', 'enclosed_areas')})
    errors = os.path.join(folder, 'ate.json')
    if os.path.exists(errors):
        own, *odometry = read_json(errors)['estimates']
        row.update(ate_rmse_m=own['rmse_m'], ate_max_m=own['max_m'],
                   heading_rmse_rad=own['heading_rmse_rad'])
        row.update({'odometry_rmse_m': estimate['rmse_m'] for estimate in odometry})
    return row


def write(folders, commit, programs, table_path, page_path):
    rows = [row_of(folder) for folder in folders]
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, restval='', lineterminator='\n')
    writer.writeheader()
    writer.writerows(rows)
    write_text(table_path, text.getvalue())
    cells = [(None, [escape(number(row.get(column), FORMS.get(column, '%s'))).replace(',', ', ')
                     for column in COLUMNS]) for row in rows]
    write_text(page_path, document('Sweep', '<p>Commit %s, programs %s. Errors (ATE) are of the trajectory '
                                   'after alignment to the truth, where there is one.</p>%s' % (
                                       escape(commit or 'unknown'), escape(programs),
                                       table([column.replace('_', '<br>') for column in COLUMNS], cells, 'words'))))
