#!/usr/bin/env python3
"""Maps a simulated bag with the matcher and compares the trajectory with the truth."""

import json
import subprocess
import tempfile
import unittest

import roslib.packages
import rostest


def run(program, *arguments):
    path = roslib.packages.find_node("matchbox_slam", program)[0]
    return subprocess.run([path, *arguments], check=True, stdout=subprocess.PIPE).stdout


class MapRooms(unittest.TestCase):
    def test_trajectory_is_true(self):
        with tempfile.TemporaryDirectory() as folder:
            bag, truth = f"{folder}/rooms.bag", f"{folder}/truth.tum"
            run("simulate", "--world", "rooms", "--bag", bag, "--truth", truth, "--duration", "30")
            run("map_bag", bag, "--out", folder, "--matcher", "hill_climbing")
            report = run("evaluate", "ate", f"{folder}/trajectory.tum", "--truth", truth, "--json")
            self.assertLess(json.loads(report)["estimates"][0]["rmse_m"], 0.05)


if __name__ == "__main__":
    rostest.rosrun("example_matcher", "map_rooms", MapRooms)
