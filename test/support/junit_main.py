#!/usr/bin/env python3
"""junit_main.py RESULT.xml TEST.py: runs the unit tests of a Python file and writes the results as JUnit XML.
Python has no such writer of its own, and catkin counts only such files."""

import os
import sys
import time
import unittest
import xml.etree.ElementTree as ElementTree


class Result(unittest.TextTestResult):
    """Keeps what became of every test."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.cases = []

    def startTest(self, test):
        super().startTest(test)
        self.started = time.monotonic()

    def note(self, test, outcome=None, text=''):
        name = test.id().split('.')
        case = ElementTree.Element('testcase', classname='.'.join(name[:-1]), name=name[-1],
                                   time='%.3f' % (time.monotonic() - self.started))
        if outcome:
            ElementTree.SubElement(case, outcome, message=text.strip().split('\n')[-1]).text = text
        self.cases.append(case)

    def addSuccess(self, test):
        super().addSuccess(test)
        self.note(test)

    def addFailure(self, test, error):
        super().addFailure(test, error)
        self.note(test, 'failure', self._exc_info_to_string(error, test))

    def addError(self, test, error):
        super().addError(test, error)
        self.started = getattr(self, 'started', time.monotonic())
        self.note(test, 'error', self._exc_info_to_string(error, test))

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        self.note(test, 'skipped', reason)


def main(result_path, test_path):
    sys.path.insert(0, os.path.dirname(os.path.abspath(test_path)))
    name = os.path.splitext(os.path.basename(test_path))[0]
    tests = unittest.defaultTestLoader.loadTestsFromName(name)
    result = unittest.TextTestRunner(verbosity=2, resultclass=Result).run(tests)
    suite = ElementTree.Element('testsuite', name=name, tests=str(len(result.cases)),
                                failures=str(len(result.failures)), errors=str(len(result.errors)),
                                skipped=str(len(result.skipped)))
    suite.extend(result.cases)
    os.makedirs(os.path.dirname(os.path.abspath(result_path)), exist_ok=True)
    ElementTree.ElementTree(suite).write(result_path, encoding='utf-8', xml_declaration=True)
    return 0 if result.wasSuccessful() and result.cases else 1


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
