"""Of test/matching/matcher_conformance_main.cpp: what matcher_conformance does with wrong usage.
Environment: MATCHBOX_CONFORMANCE, the program."""

import os
import subprocess
import unittest


def run(*arguments):
    return subprocess.run([os.environ['MATCHBOX_CONFORMANCE'], *arguments], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True)


class ConformanceProgram(unittest.TestCase):

    def test_a_filter_that_matches_nothing_is_wrong_usage(self):
        for more in ([], ['--gtest_list_tests']):
            done = run('matchbox_slam/OdometryOnly', '--gtest_filter=*Coridor*', *more)
            self.assertEqual(done.returncode, 2, done.stdout)
            self.assertEqual(done.stderr, "matcher_conformance: no test matches --gtest_filter=*Coridor*; "
                             "see --gtest_list_tests\n")

    def test_one_that_matches_some_runs_them(self):
        done = run('matchbox_slam/OdometryOnly', '--gtest_filter=*Corridor*')
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual(done.stderr, '')


if __name__ == '__main__':
    unittest.main()
