"""Of scripts/workspace.sh: the scripts that build, test and demonstrate tell wrong usage from work that failed."""

import pathlib
import subprocess
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / 'scripts'


class Scripts(unittest.TestCase):

    def test_wrong_usage_exits_with_2_and_one_line(self):
        for name, *arguments in (('build.sh', 'all'), ('build.sh', '--hlep'), ('test.sh', '--hlep'),
                                 ('test.sh', '--style', 'test_map'), ('check_style.sh', '--hlep'),
                                 ('coverage.sh', 'map'), ('coverage.sh', '--floor'), ('coverage.sh', '--floor', 'high'),
                                 ('sanitize.sh', 'adress'), ('sanitize.sh', 'thread', 'map'),
                                 ('demo.sh', '--hlep'), ('demo.sh', 'none.bag'), ('test_aarch64.sh', 'map'),
                                 ('try_platforms.sh', 'buster'), ('try_platforms.sh', '--folder')):
            done = subprocess.run([SCRIPTS / name, *arguments], stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True)
            self.assertEqual(done.returncode, 2, (name, arguments, done.stderr))
            self.assertEqual(done.stdout, '')
            self.assertRegex(done.stderr, f'^{name}: [^\n]+\n$')


if __name__ == '__main__':
    unittest.main()
