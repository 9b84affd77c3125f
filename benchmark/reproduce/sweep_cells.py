"""The cells of a sweep: which bag is mapped by which matcher, with which settings and seed."""

import collections
import hashlib
import itertools
import os
import re

import yaml

import experiments
from experiments import Mistake

Cell = collections.namedtuple('Cell', 'bag matcher setting seed')
KEYS = {'bags', 'matchers', 'grid', 'seeds'}
BAG_KEYS = {'simulate', 'bag', 'truth', 'map_options', 'truth_options'}
NAME = re.compile(r'[\w.+-]+')
LONGEST_NAME = 100


class Loader(yaml.SafeLoader):
    """YAML in which no key is given twice: the first would be lost."""

    def construct_mapping(self, node, deep=False):
        keys = [self.construct_object(key, deep=True) for key, _ in node.value]
        for key in keys:
            require(keys.count(key) == 1, '%s is given twice' % (key,))
        return super().construct_mapping(node, deep)


def require(condition, what):
    if not condition:
        raise Mistake(what)


def is_scalar(value):
    return isinstance(value, (str, int, float))


def require_list(values, what, kind):
    """A list without repetition whose values the kind (a function) allows."""
    require(isinstance(values, list) and values, '%s: should be a list, such as [a, b]' % what)
    for value in values:
        require(kind(value), '%s: %s cannot be one' % (what, value))
        require(values.count(value) == 1, '%s: %s is given twice' % (what, value))


def require_name(name, what):
    require(isinstance(name, str), '%s %s: YAML reads this name as a number or a date; put it in quotes' % (what, name))
    require(NAME.fullmatch(name) and name.strip('.'), '%s %s: a name has letters, digits and . + - _' % (what, name))


def check_bag(name, entry, folder):
    require_name(name, 'bag')
    what = 'bag ' + name
    require(isinstance(entry, dict) and ('simulate' in entry) != ('bag' in entry),
            what + ' needs either simulate or bag')
    unknown = set(entry) - BAG_KEYS
    require(not unknown, '%s: unknown keys: %s' % (what, ', '.join(sorted(map(str, unknown)))))
    if 'simulate' in entry:
        options = entry['simulate']
        require(isinstance(options, dict) and options and all(map(is_scalar, options.values())),
                what + ': simulate needs options of the program, such as {world: rooms}')
        require('truth' not in entry and 'truth_options' not in entry,
                what + ': what is simulated has its truth; no truth, no truth_options')
        files = []
    else:
        files = [entry['bag']] if isinstance(entry['bag'], str) else entry['bag']
        require_list(files, what, lambda path: isinstance(path, str) and path)
        require('truth' in entry or 'truth_options' not in entry, what + ': truth_options without truth')
        if 'truth' in entry:
            require(isinstance(entry['truth'], str) and entry['truth'], what + ': truth should be a file')
            files = files + [entry['truth']]
    for path in files:
        require(os.path.isfile(os.path.join(folder, path)), '%s: %s: no such file' % (
            what, os.path.join(folder, path)))
    experiments.check_map_options(entry.get('map_options'), what + ': map_options')
    experiments.words(entry.get('truth_options'), what + ': truth_options')


def check(sweep, folder):
    require(isinstance(sweep, dict) and sweep.get('bags') and sweep.get('matchers'), 'needs bags and matchers')
    unknown = set(sweep) - KEYS
    require(not unknown, 'unknown keys: %s' % ', '.join(sorted(map(str, unknown))))
    require(isinstance(sweep['bags'], dict), 'bags: each needs a name, such as {office: {bag: office.bag}}')
    for name, entry in sweep['bags'].items():
        check_bag(name, entry, folder)
    require_list(sweep['matchers'], 'matchers', is_scalar)
    for name in sweep['matchers']:
        require_name(name, 'matcher')
    grid = sweep.get('grid', {})
    require(isinstance(grid, dict) and all(isinstance(key, str) for key in grid),
            'grid: should be parameters, each with a list of values')
    experiments.check_settings(grid, 'grid')
    for key, values in grid.items():
        require_list(values, 'grid: ' + key, is_scalar)
    if 'seeds' in sweep:
        require_list(sweep['seeds'], 'seeds', lambda seed: type(seed) is int and 0 <= seed < 2 ** 31)


def read(path):
    """The file's contents, with what may be left out."""
    try:
        with open(path) as file:
            sweep = yaml.load(file, Loader)
        check(sweep, os.path.dirname(os.path.abspath(path)))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise Mistake('%s: not YAML: %s' % (path, error))
    except Mistake as mistake:
        raise Mistake('%s: %s' % (path, mistake))
    grid = {key: [str(value).lower() if isinstance(value, bool) else value for value in values]
            for key, values in sweep.get('grid', {}).items()}
    return dict({'seeds': [1]}, **dict(sweep, grid=grid))


def recordings(sweep, path):
    """What is mapped, by name."""
    folder = os.path.dirname(os.path.abspath(path))
    return {name: experiments.Recording(['bags/%s.bag' % name], 'bags/%s.tum' % name,
                                        experiments.words(entry.get('map_options'), name), [])
            if 'simulate' in entry else experiments.recording(entry, folder)
            for name, entry in sweep['bags'].items()}


def text_of(settings):
    return ', '.join('%s=%s' % item for item in sorted(settings.items())) or 'default'


def name_of(settings):
    """A folder's name for a combination of settings."""
    name = re.sub(r'[^\w.+=,-]', lambda match: '%%%02x' % ord(match.group()),
                  text_of(settings).replace('/', '.').replace(', ', ','))
    return name if len(name) <= LONGEST_NAME else 'settings-' + hashlib.sha256(name.encode()).hexdigest()[:16]


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
