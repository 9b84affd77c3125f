#include <gtest/gtest.h>

#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "matching/olson/lattice_blocks.hpp"

namespace matchbox_slam {
namespace {

constexpr double kBlockResolution = 0.05;

SearchLattice lattice_of(int steps_per_cell, int half_xy, int half_theta) {
  SearchLattice lattice;
  lattice.steps_per_cell = steps_per_cell;
  lattice.half_xy = half_xy;
  lattice.half_theta = half_theta;
  lattice.step_theta = 0.004;
  return lattice;
}

PointArrays points_around(int count) {
  Random random(5);
  PointArrays points;
  for (int i = 0; i < count; ++i) {
    points.x.push_back(random.uniform(-8.0, 8.0));
    points.y.push_back(random.uniform(-8.0, 8.0));
    points.weights.push_back(1);
  }
  return points;
}

TEST(LatticeBlocks, CoverEachStepOnce) {
  const PointArrays points = points_around(20);
  for (const int steps_per_cell : {1, 2, 5, 16}) {
    for (const int half : {0, 1, 7, 16, 100, 801}) {
      LatticeBlocks blocks;
      blocks.assign(points, lattice_of(steps_per_cell, half, 0), kBlockResolution);
      for (int level = 0; level <= blocks.top(); ++level) {
        const StepRange all = blocks.blocks_of(level);
        int next = -half;
        for (int block = all.first; block <= all.last; ++block) {
          const StepRange steps = blocks.steps_of(level, block);
          EXPECT_EQ(steps.first, next) << "level " << level << " block " << block;
          EXPECT_GE(steps.count(), 1);
          EXPECT_LE(steps.count(), steps_per_cell * LatticeBlocks::bounds_of(level).stride);
          next = steps.last + 1;
        }
        EXPECT_EQ(next, half + 1) << "level " << level;
        EXPECT_LE(blocks.steps_of(level, all.first - 1).count(), 0);
        EXPECT_LE(blocks.steps_of(level, all.last + 1).count(), 0);
      }
    }
  }
}

TEST(LatticeBlocks, GroupEachRotationOnce) {
  const PointArrays points = points_around(20);
  for (const int half_theta : {0, 1, 30, 785}) {
    LatticeBlocks blocks;
    blocks.assign(points, lattice_of(2, 100, half_theta), kBlockResolution);
    for (int level = 0; level <= blocks.top(); ++level) {
      int next = -half_theta;
      for (int group = 0; group <= blocks.last_group(level); ++group) {
        const StepRange thetas = blocks.thetas_of(level, group);
        EXPECT_EQ(thetas.first, next) << "level " << level << " group " << group;
        EXPECT_EQ(blocks.group_of(level, thetas.first), group);
        EXPECT_EQ(blocks.group_of(level, thetas.last), group);
        next = thetas.last + 1;
      }
      EXPECT_EQ(next, half_theta + 1) << "level " << level;
    }
    EXPECT_EQ(blocks.last_group(0), 2 * half_theta) << "single rotations";
  }
}

TEST(LatticeBlocks, UseCoarserLevelsForWiderWindowsAlone) {
  const PointArrays points = points_around(20);
  LatticeBlocks blocks;
  const auto top_of = [&](int half_cells) {
    blocks.assign(points, lattice_of(2, 2 * half_cells, 10), kBlockResolution);
    return blocks.top();
  };
  EXPECT_EQ(top_of(0), 1);
  EXPECT_EQ(top_of(3), 1);
  EXPECT_EQ(top_of(10), 2);
  EXPECT_EQ(top_of(100), 3);
  EXPECT_EQ(top_of(2000), 3);
  EXPECT_EQ(top_of(0), 1) << "after a wide one";
}

}  // namespace
}  // namespace matchbox_slam
