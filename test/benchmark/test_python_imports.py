"""Whatever the Python programs of scripts/ and benchmark/ import, package.xml names, or a page where it is optional."""

import ast
import os
import sys
import unittest
import xml.etree.ElementTree as ElementTree

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))

# The key in package.xml that brings a module, where it is not the module's name.
KEYS = {'catkin_pkg': 'catkin', 'genpy': 'rospy', 'matplotlib': 'python3-matplotlib', 'numpy': 'python3-numpy',
        'scipy': 'python3-scipy', 'yaml': 'python3-yaml'}

# sys.stdlib_module_names is of Python 3.10.
STANDARD = getattr(sys, 'stdlib_module_names', None)


def sources():
    for folder in ('scripts', 'benchmark'):
        for path, folders, files in os.walk(os.path.join(SOURCE, folder)):
            folders[:] = [name for name in folders if name != 'reports']
            for name in files:
                with open(os.path.join(path, name), errors='replace') as file:
                    text = file.read()
                if name.endswith('.py') or text.startswith(('#!/usr/bin/python3', '#!/usr/bin/env python3')):
                    yield os.path.join(path, name), text


def imported(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (alias.name.split('.')[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module.split('.')[0]


@unittest.skipUnless(STANDARD, 'this Python does not say which modules are its own')
class PythonImports(unittest.TestCase):
    def test_package_xml_names_what_is_imported(self):
        package = ElementTree.parse(os.path.join(SOURCE, 'package.xml')).getroot()
        named = {entry.text for entry in package if entry.tag.endswith('depend')}
        own = {os.path.splitext(os.path.basename(path))[0] for path, _ in sources()} | {'matchbox_slam'}
        modules = {}
        for path, text in sources():
            for module in imported(text):
                if module not in own and module not in STANDARD:
                    modules.setdefault(module, os.path.relpath(path, SOURCE))
        self.assertIn('numpy', modules)
        for module, path in modules.items():
            self.assertIn(KEYS.get(module, module), named, f'{path} imports {module}')


if __name__ == '__main__':
    unittest.main()
