"""What the programs wrote into a job's folder, once it is sure to be of that job."""

import os
import re

from files import Failed, read_json, require


def short_name(lookup_name):
    """As `matcher_short_name` of the package: matchbox_slam/MonteCarlo is monte_carlo, a/ICPCustom icp_custom."""
    name = lookup_name.rsplit('/', 1)[-1]
    return re.sub(r'(?<=[^_A-Z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][^A-Z])', '_', name).lower()


def check_report(told, matcher, seed):
    """A result has to be of the cell in whose folder it lies."""
    if (short_name(told['matcher']), str(told['seed'])) != (matcher, str(seed)):
        raise Failed('its report is of %s with seed %s, instead of %s with seed %s' % (
            short_name(told['matcher']), told['seed'], matcher, seed))


def result_of_pairs(folder, matcher, seed):
    """What match_pairs wrote into a folder, maybe for several matchers: the summary, and of it the matcher's part."""
    paths = [os.path.join(folder, name) for name in ('summary.json', 'pairs.csv')]
    require(paths, os.path.join(folder, 'match_pairs.log'))
    summary = read_json(paths[0])
    row = next((row for row in summary['matchers'] if short_name(row['matcher']) == matcher), summary['matchers'][0])
    check_report({'matcher': row['matcher'], 'seed': summary['seed']}, matcher, seed)
    return summary, row


def result_of_map(folder, matcher, seed, has_truth):
    """What map_bag and evaluate wrote into a folder: the report, the quality and the errors."""
    path = os.path.join(folder, 'report.json')
    require([path], os.path.join(folder, 'map_bag.log'))
    report = read_json(path)
    check_report(report, matcher, seed)
    require([os.path.join(folder, 'quality.json')], os.path.join(folder, 'quality.log'))
    quality = read_json(os.path.join(folder, 'quality.json'))['maps'][0]
    errors = []
    if has_truth:
        require([os.path.join(folder, 'ate.json')], os.path.join(folder, 'ate.log'))
        errors = read_json(os.path.join(folder, 'ate.json'))['estimates']
    return report, quality, errors


class Made:
    """By what, where and when the results were made."""

    def __init__(self):
        self.commits, self.versions, self.machines = set(), set(), {}

    def add(self, report):
        self.commits.add(report['commit'])
        self.versions.add(report['version'])
        machine = report['machine']
        name = '%s (%s, %d cores)' % (machine['host'], machine['cpu'], machine['cores'])
        self.machines.setdefault(name, set()).add(report['date'])

    def places(self):
        """Sentences' parts: each machine, with the days."""
        return ['%s on %s' % (name, ', '.join(sorted(days))) for name, days in sorted(self.machines.items())]
