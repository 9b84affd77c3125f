"""Pieces of pages that need no other file."""

import base64
import html
import os


def escape(value):
    return html.escape(str(value))


def table(table, name='', convert=escape):
    """A tables.Table; `convert` makes HTML of a cell's text."""
    lines = ['<div class="scroll"><table class="%s"><thead><tr>' % name]
    lines += ['<th>%s</th>' % escape(cell).replace('\n', '<br>') for cell in table.header]
    lines.append('</tr></thead><tbody>')
    for kind, cells in table.rows:
        lines.append('<tr%s>' % (' class="%s"' % kind if kind else ''))
        # Why something failed reaches over the other columns.
        wide = ' colspan="%d"' % (len(table.header) - 1) if kind == 'failed' else ''
        lines += ['<td%s>%s</td>' % (wide if i else '', convert(cell)) for i, cell in enumerate(cells)] + ['</tr>']
    return '\n'.join(lines + ['</tbody></table></div>'])


def figure(path, caption, reason, wide=False):
    """A picture inside the page; where there is none, the reason."""
    if os.path.exists(path):
        with open(path, 'rb') as file:
            picture = base64.b64encode(file.read()).decode()
        content = '<div class="scroll"><img alt="%s" src="data:image/png;base64,%s"></div>' % (
            escape(caption), picture)
    else:
        content = '<div class="bad">failed: %s</div>' % escape(reason)
    return '<figure%s>%s<figcaption>%s</figcaption></figure>' % (
        ' class="wide"' if wide else '', content, escape(caption))


def box(good, title, items=()):
    return '<div class="%s">%s%s</div>' % (
        'good' if good else 'bad', escape(title),
        '<ul>%s</ul>' % ''.join('<li>%s.</li>' % escape(item) for item in items) if items else '')


def document(title, body):
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), 'page.css')) as file:
        style = file.read()
    return ('<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n<meta name="viewport" '
            'content="width=device-width, initial-scale=1">\n<title>%s</title>\n'
            '<style>\n%s</style></head>\n<body>\n<h1>%s</h1>\n%s\n</body></html>\n' % (
                escape(title), style, escape(title), body))
