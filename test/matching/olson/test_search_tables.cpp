#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "matching/olson/field_values.hpp"
#include "matching/olson/search_tables.hpp"

namespace matchbox_slam {
namespace {

constexpr double kTableResolution = 0.05;

struct ScatteredScene {
  LikelihoodField field{kTableResolution, {}};
  PointArrays points;
  SearchLattice lattice;
};

/// Points all over and beyond a field of hits.
ScatteredScene make_scattered_scene() {
  Random random(11);
  ScatteredScene scene;
  std::vector<SurfaceHit> hits;
  for (int i = 0; i < 200; ++i) {
    hits.push_back({{random.uniform(-4.0, 4.0), random.uniform(-4.0, 4.0)}, {0.0, 0.0}});
  }
  scene.field.update(hits, {});
  for (int i = 0; i < 60; ++i) {
    const double size = i % 10 == 0 ? 90.0 : 5.0;
    scene.points.x.push_back(random.uniform(-size, size));
    scene.points.y.push_back(random.uniform(-size, size));
    scene.points.weights.push_back(static_cast<std::uint16_t>(1 + i));
  }
  scene.lattice.center = {0.312, -0.207, 0.4};
  scene.lattice.steps_per_cell = 3;
  scene.lattice.half_xy = 60;
  scene.lattice.half_theta = 20;
  scene.lattice.step_theta = 0.01;
  return scene;
}

std::uint8_t likelihood_at(const ScatteredScene& scene, std::size_t point,
                           const LatticePose& pose) {
  const Pose2 there = pose_at(scene.lattice, pose, kTableResolution);
  const Eigen::Vector2d at = there * Eigen::Vector2d(scene.points.x[point], scene.points.y[point]);
  return scene.field.likelihood(scene.field.geometry().cell_at(at));
}

LatticeBlocks blocks_of(const ScatteredScene& scene) {
  LatticeBlocks blocks;
  blocks.assign(scene.points, scene.lattice, kTableResolution);
  return blocks;
}

TEST(SearchTables, HaveTheCellsOfPointsAndTheirSteps) {
  const ScatteredScene scene = make_scattered_scene();
  const LatticeBlocks blocks = blocks_of(scene);
  SearchTables tables;
  tables.assign(scene.points, blocks, scene.field, unchanged_values());
  ASSERT_FALSE(tables.empty());
  const int n = scene.lattice.steps_per_cell;
  for (const int theta : {-20, 0, 7, 20}) {
    for (const int move : {-20, -3, 0, 19}) {
      const SearchTables::Cells cells = tables.cells(theta, move, -move);
      ASSERT_EQ(cells.windows.count, scene.points.x.size());
      for (std::size_t i = 0; i < cells.windows.count; ++i) {
        const std::uint8_t expected = likelihood_at(scene, i, {move * n, -move * n, theta});
        const int weight = cells.windows.weights[i];
        if (weight == 0) {
          EXPECT_EQ(expected, 0) << "point " << i << " is left out";
        } else {
          EXPECT_EQ(weight, scene.points.weights[i]);
          EXPECT_EQ(cells.windows.table[cells.windows.offsets[i]], expected) << "point " << i;
        }
        EXPECT_GE(cells.classes[i], 0);
        EXPECT_LT(cells.classes[i], n * n);
      }
    }
  }
}

TEST(SearchTables, BoundWhatTheScanMeetsInABlockAtAGroupOfRotations) {
  const ScatteredScene scene = make_scattered_scene();
  const LatticeBlocks blocks = blocks_of(scene);
  SearchTables tables;
  tables.assign(scene.points, blocks, scene.field, unchanged_values());
  Random random(3);
  for (int level = 0; level <= blocks.top(); ++level) {
    const StepRange all = blocks.blocks_of(level);
    for (int i = 0; i < 40; ++i) {
      const int group = static_cast<int>(random.uniform() * (blocks.last_group(level) + 1));
      const int x = all.first + static_cast<int>(random.uniform() * all.count());
      const int y = all.first + static_cast<int>(random.uniform() * all.count());
      const PointWindows windows = tables.bounds(level, group, x, y);
      std::int64_t bound = blocks.scan_of(level).unbounded;
      for (std::size_t p = 0; p < windows.count; ++p) {
        bound += std::int64_t{windows.weights[p]} * windows.table[windows.offsets[p]];
      }
      const auto any_of = [&](const StepRange& steps) {
        return steps.first + static_cast<int>(random.uniform() * steps.count());
      };
      for (int j = 0; j < 20; ++j) {
        const LatticePose pose{any_of(blocks.steps_of(level, x)), any_of(blocks.steps_of(level, y)),
                               any_of(blocks.thetas_of(level, group))};
        std::int64_t fit = 0;
        for (std::size_t p = 0; p < scene.points.x.size(); ++p) {
          fit += std::int64_t{scene.points.weights[p]} * likelihood_at(scene, p, pose);
        }
        EXPECT_LE(fit, bound) << "level " << level;
      }
    }
  }
}

TEST(SearchTables, AreEmptyWhereNothingIsInReach) {
  ScatteredScene scene = make_scattered_scene();
  scene.lattice.center.x = 500.0;
  LatticeBlocks blocks;
  blocks.assign(scene.points, scene.lattice, kTableResolution);
  SearchTables tables;
  tables.assign(scene.points, blocks, scene.field, unchanged_values());
  EXPECT_TRUE(tables.empty());
  const LikelihoodField none(kTableResolution, {});
  tables.assign(scene.points, blocks, none, unchanged_values());
  EXPECT_TRUE(tables.empty());
}

}  // namespace
}  // namespace matchbox_slam
