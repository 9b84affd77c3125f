"""What tests of a program of benchmark/ share."""

import os
import subprocess
import sys
import tempfile
import unittest

BENCHMARK = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__)))), 'benchmark')


class ProgramTest(unittest.TestCase):
    """Runs `program` on files of a folder that is there for all tests of the class."""

    program = None

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder.name, name)

    def run_on(self, *arguments):
        return subprocess.run([sys.executable, os.path.join(BENCHMARK, self.program), *arguments],
                              capture_output=True, text=True, timeout=60)
