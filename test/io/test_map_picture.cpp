#include <gtest/gtest.h>

#include <algorithm>

#include "io/map_picture.hpp"

namespace matchbox_slam {
namespace {

bool is_dark(Color color) { return color.red < 60 && color.green < 60 && color.blue < 80; }
bool is_white(Color color) { return color.red == 255 && color.green == 255 && color.blue == 255; }
bool is_blue(Color color) { return color.blue > color.red + 100 && color.blue > color.green + 60; }
bool is_orange(Color color) {
  return color.red > color.blue + 100 && color.green > color.blue + 40;
}
bool is_grey(Color color) { return color.red > 200 && color.red < 240; }

struct Extent {
  int left = 1 << 20;
  int right = -1;
  int top = 1 << 20;
  int bottom = -1;
  int count = 0;
};

/// Where in the upper part of the picture, that is in the map, there are pixels of a kind.
template <typename Kind>
Extent extent_of(const Picture& picture, Kind&& is_of_kind) {
  Extent extent;
  for (int y = 0; y < picture.height() - 57; ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      if (is_of_kind(picture.color_at(x, y))) {
        ++extent.count;
        extent.left = std::min(extent.left, x);
        extent.right = std::max(extent.right, x);
        extent.top = std::min(extent.top, y);
        extent.bottom = std::max(extent.bottom, y);
      }
    }
  }
  return extent;
}

/// 100 x 50 free cells with a wall in the upper left corner.
OccupancyGrid room(double resolution = 0.1) {
  OccupancyGrid grid(resolution);
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 100; ++x) {
      grid.blend({x, y}, x < 10 && y >= 45 ? 1.0 : 0.0, 1.0);
    }
  }
  return grid;
}

TEST(DrawMap, HasXToTheRightAndYUp) {
  const Picture picture = draw_map(room(), {}, {});
  const Extent free = extent_of(picture, is_white);
  const Extent wall = extent_of(picture, is_dark);
  EXPECT_EQ((free.right - free.left + 1) % 100, 0);  // a whole number of pixels a cell
  const int pixels_per_cell = (free.right - free.left + 1) / 100;
  EXPECT_EQ(pixels_per_cell, 12);
  EXPECT_EQ(wall.count, 10 * 5 * pixels_per_cell * pixels_per_cell);
  EXPECT_EQ(wall.left, free.left);
  EXPECT_EQ(wall.top, free.top);
  EXPECT_EQ(free.bottom - free.top + 1, 50 * pixels_per_cell);
}

TEST(DrawMap, DrawsTheTrajectoryWhereItIs) {
  const Trajectory trajectory({{0.0, {5.0, 1.0, 0}}, {1.0, {8.0, 1.0, 0}}});
  const Picture picture = draw_map(room(), trajectory, {});
  const Extent free = extent_of(picture, is_white);
  const Extent line = extent_of(picture, is_blue);
  EXPECT_NEAR(line.right, free.left + 80 * 12, 3);
  EXPECT_NEAR(0.5 * (line.top + line.bottom), free.bottom - 10 * 12, 2);
  EXPECT_EQ(extent_of(picture, is_orange).count, 0);
}

TEST(DrawMap, OdometryStartsWhereTheTrajectoryStarts) {
  // In its own frame the odometry starts elsewhere and heads along y; in the map it goes along x.
  const Trajectory trajectory({{0.0, {2.0, 2.0, 0}}, {1.0, {2.0, 3.0, 0}}});
  const Trajectory odometry({{0.0, {70.0, -30.0, 0.5 * kPi}}, {1.0, {70.0, -25.0, 0}}});
  const Picture picture = draw_map(room(), trajectory, odometry);
  const Extent free = extent_of(picture, is_white);
  const Extent line = extent_of(picture, is_orange);
  EXPECT_NEAR(line.left, free.left + 20 * 12, 16);   // its first part is below the start's marker
  EXPECT_NEAR(line.right, free.left + 70 * 12, 10);  // its end may be a gap
  EXPECT_NEAR(0.5 * (line.top + line.bottom), free.bottom - 20 * 12, 2);
}

TEST(DrawMap, DrawsTheLoopsThatAreBelieved) {
  PoseGraph graph;
  graph.poses = {{2.0, 1.0, 0.0}, {6.0, 1.0, 0.0}, {6.0, 4.0, 0.0}};
  const Eigen::Matrix3d known = Eigen::Matrix3d::Identity();
  graph.edges = {{0, 1, {}, known, EdgeKind::kLoop, LoopVerdict::kInlier},
                 {0, 2, {}, known, EdgeKind::kLoop, LoopVerdict::kOutlier},
                 {1, 2, {}, known}};
  const auto is_loop = [](Color color) {
    return color.red > color.green + 100 && color.blue > color.green + 60;
  };
  const Picture picture = draw_map(room(), {}, {}, graph);
  const Extent free = extent_of(picture, is_white);
  const Extent line = extent_of(picture, is_loop);
  EXPECT_NEAR(line.left, free.left + 20 * 12, 3);
  EXPECT_NEAR(line.right, free.left + 60 * 12, 6);
  EXPECT_NEAR(0.5 * (line.top + line.bottom), free.bottom - 10 * 12, 2);
  const auto in_legend = [&](const Picture& drawn) {
    int count = 0;
    for (int x = 0; x < drawn.width(); ++x) {
      count += is_loop(drawn.color_at(x, drawn.height() - 28)) ? 1 : 0;
    }
    return count;
  };
  EXPECT_GT(in_legend(picture), 20);
  EXPECT_EQ(in_legend(draw_map(room(), {}, {})), 0);
}

TEST(DrawMap, ShowsATrajectoryOutsideTheMapOnUnknownGround) {
  const Trajectory trajectory({{0.0, {5.0, 2.0, 0}}, {1.0, {5.0, 12.0, 0}}});
  const Picture picture = draw_map(room(), trajectory, {});
  const Extent line = extent_of(picture, is_blue);
  const Extent free = extent_of(picture, is_white);
  EXPECT_GT(free.top - line.top, 500);
  EXPECT_TRUE(is_grey(picture.color_at(line.left - 20, line.top + 5)));
}

TEST(DrawMap, HugeMapsStayBelowFourThousandPixelsAndKeepThinWalls) {
  OccupancyGrid grid(0.05);
  for (int x = 0; x < 9000; ++x) {
    grid.blend({x, 0}, 0.0, 1.0);
    grid.blend({x, 1}, 1.0, 1.0);
    grid.blend({x, 2}, 0.0, 1.0);
  }
  const Picture picture = draw_map(grid, {}, {});
  EXPECT_LE(picture.width(), 4050);
  EXPECT_GE(picture.width(), 3000);
  EXPECT_EQ(extent_of(picture, is_dark).count, 3000);
}

TEST(DrawMap, WorksWithoutAnythingAndWithPosesFarAway) {
  EXPECT_GT(draw_map(OccupancyGrid(0.05), {}, {}).width(), 0);
  const Trajectory far({{0.0, {0, 0, 0}}, {1.0, {9.0e4, 9.0e4, 0}}, {2.0, {1e200, 0, 0}}});
  EXPECT_LE(draw_map(room(), far, far).width(), 4050);
}

}  // namespace
}  // namespace matchbox_slam
