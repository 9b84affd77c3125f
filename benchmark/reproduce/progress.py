"""Snakemake's log handler: one line a finished job, and what went wrong."""

import os
import sys

from snakemake.logging import logger

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import files  # noqa: E402  the path comes first

# Snakemake's own handler tells ten lines a job, and its --quiet would silence the progress as well.
if logger.text_handler in logger.log_handler:
    logger.log_handler.remove(logger.text_handler)

names = {}
finished = []
reasons = set()


def describe(message):
    wildcards = message.get('wildcards') or {}
    values = wildcards.values() if hasattr(wildcards, 'values') else wildcards
    return ' '.join([message['name'].replace('_', ' ')] + [str(value) for value in values])


def tell(text):
    print(text, file=sys.stderr, flush=True)


def why(message):
    """What the program of a failed job said; of several that say the same, once."""
    said = ' '.join(files.reason(log) for log in message.get('log') or []) or str(message.get('shellcmd'))
    if said in reasons:
        return 'the same'
    reasons.add(said)
    if message['name'] == 'map_bag' and any(word in said for word in ('topic', 'frame', '--')):
        return said + ' (to be given by --map-options "...", in a sweep by map_options)'
    return said


def log_handler(message):
    level = message['level']
    if level == 'job_info':
        names[message['jobid']] = describe(message)
    elif level == 'job_finished':
        finished.append(names.get(message['jobid'], 'a job'))
    elif level == 'progress':
        tell('%d of %d: %s' % (message['done'], message['total'], ', '.join(finished)))
        finished.clear()
    elif level == 'job_error':
        tell('FAILED: %s: %s' % (names.get(message['jobid'], message['name']), why(message)))
    elif level == 'error':
        tell(message['msg'])
    elif level == 'info' and message['msg'].startswith('Nothing to be done'):
        tell('nothing to be done')
