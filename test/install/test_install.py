"""What is installed serves who builds against it: a program that embeds the core, and a matcher of one's own.
So does the workspace that it is built in.
Environment: MATCHBOX_BUILD, the package's build folder, where all is built, MATCHBOX_CXX, the compiler that
built it, and MATCHBOX_DEVEL, with ROS the workspace's devel space."""

import math
import os
import pathlib
import subprocess
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def run(*command, **options):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          **options)
    if done.returncode:
        raise AssertionError(f"{' '.join(map(str, command))}\n{done.stdout}")
    return done.stdout


class Install(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.prefix = pathlib.Path(cls.folder.name, 'install')
        run('cmake', f'-DCMAKE_INSTALL_PREFIX={cls.prefix}',
            '-P', os.path.join(os.environ['MATCHBOX_BUILD'], 'cmake_install.cmake'))

    def build(self, source, prefix=None):
        """Returns the build folder. Nothing but what lies below `prefix` is in sight."""
        prefix = prefix or self.prefix
        build = os.path.join(self.folder.name, 'build', prefix.name, source.name)
        environment = {'PATH': '/usr/bin:/bin', 'CXX': os.environ['MATCHBOX_CXX']}
        run('cmake', '-S', source, '-B', build, f'-DCMAKE_PREFIX_PATH={prefix};/usr',
            '-DPYTHON_EXECUTABLE=/usr/bin/python3', env=environment)
        run('cmake', '--build', build, env=environment)
        return build

    def test_a_program_embeds_the_core(self):
        build = self.build(SOURCE / 'test/install/embedding')
        known = float(run('./embedding', cwd=build))
        self.assertAlmostEqual(known, math.pi * 2.0**2, delta=0.5)  # the room, and its wall
        self.assertTrue(os.path.exists(os.path.join(build, 'map.pgm')))

    def test_only_headers_for_others_are_installed(self):
        headers = {path.relative_to(self.prefix / 'include/matchbox_slam')
                   for path in self.prefix.glob('include/matchbox_slam/*/**/*.hpp')}
        self.assertEqual(headers, {path.relative_to(SOURCE / 'include/matchbox_slam')
                                   for path in SOURCE.glob('include/matchbox_slam/**/*.hpp')})

    def test_a_matcher_builds_against_it(self):
        if not (self.prefix / 'share/matchbox_slam/package.xml').exists():
            self.skipTest('built without ROS')
        for prefix in [self.prefix, pathlib.Path(os.environ['MATCHBOX_DEVEL'])]:
            build = self.build(SOURCE / 'doc/example_matcher', prefix)
            self.assertTrue(os.path.exists(os.path.join(build, 'devel/lib/libexample_matcher.so')))
            self.assertIn('CMAKE_BUILD_TYPE:STRING=Release',  # else a match takes 30 ms
                          pathlib.Path(build, 'CMakeCache.txt').read_text())


if __name__ == '__main__':
    unittest.main()
