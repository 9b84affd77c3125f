"""benchmark/relation_stamps.py: relations by what their stamps tell, and one line for a mistake."""

import json
import sys
import unittest

from program_test import BENCHMARK, ProgramTest


def poses(stamps_and_xs):
    return ''.join(f'{stamp:.4f} {x:.4f} 0 0 0 0 0 1\n' for stamp, x in stamps_and_xs)


class RelationStamps(ProgramTest):
    """A robot that drives along x by 1 m/s, and whose log then writes four poses down at once."""

    program = 'relation_stamps.py'

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        way = [(100.0 + 0.1 * k, 0.1 * k) for k in range(50)]
        burst = [(104.901 + 0.001 * k, 5.0 + 0.1 * k) for k in range(4)]
        relations = ['100.0 103.0 3.0 0 0 0 0 0', '101.0 104.0 3.5 0 0 0 0 0', '100.0 104.903 5.0 0 0 0 0 0']
        for name, text in (('odometry.tum', poses(way + burst)), ('estimate.tum', poses(way[::10] + burst[-1:])),
                           ('relations', '\n'.join(relations))):
            with open(cls.path(name), 'w') as file:
                file.write(text)

    def run_program(self, *arguments, relations='relations'):
        return self.run_on(self.path('estimate.tum'), '--relations', self.path(relations),
                           '--odometry', self.path('odometry.tum'), *arguments)

    def test_relations_are_told_apart_by_the_fastest_step_at_their_stamps(self):
        done = self.run_program()
        self.assertEqual(done.returncode, 0, done.stderr)
        groups = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([(g['fastest_from_m_s'], g['fastest_to_m_s'], g['relations'], g['mean_m']) for g in groups],
                         [(0.0, None, 3, 0.2333), (0.0, 2.0, 2, 0.25), (20.0, None, 1, 0.2)])

    def test_poses_of_one_stamp_stay_in_their_order(self):
        with open(self.path('turns.tum'), 'w') as file:
            file.write(poses([(100.0, 0.0), (101.0, 3.0), (101.0, 1.0), (101.0, 2.0), (102.0, 2.0)]))
        sys.path.insert(0, BENCHMARK)
        from relation_stamps import Trajectory  # pylint: disable=import-outside-toplevel
        self.assertEqual([pose[0] for pose in Trajectory(self.path('turns.tum')).poses], [0.0, 3.0, 1.0, 2.0, 2.0])

    def test_a_mistake_is_told_in_one_line(self):
        for done, text in ((self.run_program(relations='missing'), 'cannot be read'),
                           (self.run_program(relations='odometry.tum', *['--within', '-1']), '--within: -1'),
                           (self.run_program(relations='../'), 'cannot be read')):
            self.assertEqual(done.returncode, 2)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertIn(text, done.stderr)


if __name__ == '__main__':
    unittest.main()
