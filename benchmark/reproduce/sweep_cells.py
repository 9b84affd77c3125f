"""The cells of a sweep: which bag is mapped by which matcher, with which settings and seed."""

import collections
import itertools
import os
import re

import yaml

import experiments

Cell = collections.namedtuple('Cell', 'bag matcher setting seed')
KEYS = {'bags', 'matchers', 'grid', 'seeds'}
BAG_KEYS = {'simulate', 'bag', 'truth', 'map_options', 'truth_options'}


class Mistake(Exception):
    """The file cannot be understood."""


def read(path):
    """The file's contents, with what may be left out."""
    with open(path) as file:
        try:
            sweep = yaml.safe_load(file)
        except yaml.YAMLError as error:
            raise Mistake('%s: not YAML: %s' % (path, error))
    if not isinstance(sweep, dict) or not sweep.get('bags') or not sweep.get('matchers'):
        raise Mistake('%s: needs bags and matchers' % path)
    unknown = set(sweep) - KEYS
    for name, entry in sweep['bags'].items():
        if not re.fullmatch(r'[\w.+-]+', str(name)):
            raise Mistake('%s: bag %s: a name has letters, digits and . + - _' % (path, name))
        if not isinstance(entry, dict) or ('simulate' in entry) == ('bag' in entry):
            raise Mistake('%s: bag %s needs either simulate or bag' % (path, name))
        unknown |= set(entry) - BAG_KEYS
    if unknown:
        raise Mistake('%s: unknown keys: %s' % (path, ', '.join(sorted(map(str, unknown)))))
    return dict({'grid': {}, 'seeds': [1]}, **sweep)


def recordings(sweep, path):
    """What is mapped, by name."""
    folder = os.path.dirname(os.path.abspath(path))
    return {name: experiments.Recording(['bags/%s.bag' % name], 'bags/%s.tum' % name,
                                        entry.get('map_options', ''), '')
            if 'simulate' in entry else experiments.recording(entry, folder)
            for name, entry in sweep['bags'].items()}


def name_of(settings):
    """A folder's name for a combination of settings."""
    words = ['%s=%s' % (key.replace('/', '.'), str(value).replace('/', '%'))
             for key, value in sorted(settings.items())]
    return ','.join(words) or 'default'


def combinations(sweep, matcher):
    """The settings of the grid that differ for a matcher, by their names."""
    found = {}
    for values in itertools.product(*sweep['grid'].values()):
        settings = experiments.settings_of(matcher, dict(zip(sweep['grid'], values)))
        found[name_of(settings)] = settings
    return found


def settings(sweep):
    """All settings by name."""
    return {name: values for matcher in sweep['matchers']
            for name, values in combinations(sweep, matcher).items()}


def cells(sweep):
    """All cells, in the order of the table."""
    return [Cell(bag, matcher, setting, str(seed)) for bag in sweep['bags']
            for matcher in sweep['matchers'] for setting in combinations(sweep, matcher)
            for seed in sweep['seeds']]
