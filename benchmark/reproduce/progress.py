"""Snakemake's log handler: one line a finished job, and what went wrong."""

import sys

from snakemake.logging import logger

# Snakemake's own handler tells ten lines a job, and its --quiet would silence the progress as well.
if logger.text_handler in logger.log_handler:
    logger.log_handler.remove(logger.text_handler)

names = {}
finished = []


def describe(message):
    wildcards = message.get('wildcards') or {}
    values = wildcards.values() if hasattr(wildcards, 'values') else wildcards
    return ' '.join([message['name'].replace('_', ' ')] + [str(value) for value in values])


def tell(text):
    print(text, file=sys.stderr, flush=True)


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
        tell('FAILED: %s: %s' % (names.get(message['jobid'], message['name']), message.get('shellcmd')))
    elif level == 'error':
        tell(message['msg'])
    elif level == 'info' and message['msg'].startswith('Nothing to be done'):
        tell('nothing to be done')
