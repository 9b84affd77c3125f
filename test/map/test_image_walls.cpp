#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "map/image_viewpoints.hpp"
#include "map/image_walls.hpp"
#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

/// An image whose pixels are what a function says of their cells.
MapImage image_of(int width, int height, const std::function<CellState(const Cell&)>& state) {
  MapImage image;
  image.width = width;
  image.height = height;
  for (int y = height - 1; y >= 0; --y) {
    for (int x = 0; x < width; ++x) {
      const CellState here = state({x, y});
      image.pixels.push_back(here == CellState::kOccupied ? MapImage::kOccupiedPixel
                             : here == CellState::kFree   ? MapImage::kFreePixel
                                                          : MapImage::kUnknownPixel);
    }
  }
  return image;
}

/// A room whose walls are the border, one pixel thick, but for the right one, which is unknown.
MapImage room(int width, int height) {
  return image_of(width, height, [=](const Cell& cell) {
    if (cell.x == width - 1) {
      return CellState::kUnknown;
    }
    const bool is_wall = cell.x == 0 || cell.y == 0 || cell.y == height - 1;
    return is_wall ? CellState::kOccupied : CellState::kFree;
  });
}

TEST(ImageWalls, RangesAreThoseOfStraightWalls) {
  const ImageWalls walls(room(101, 61));
  const Eigen::Vector2d origin(40.3, 20.7);
  int hits = 0;
  for (int i = 0; i < 360; ++i) {
    const double angle = degrees_to_radians(i + 0.5);
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const double left = direction.x() < 0.0 ? (0.5 - origin.x()) / direction.x() : 1e9;
    const double across = ((direction.y() < 0.0 ? 0.5 : 60.5) - origin.y()) / direction.y();
    const double unknown = direction.x() > 0.0 ? (100.0 - origin.x()) / direction.x() : 1e9;
    const double expected = std::min(left, across);
    const double range = walls.range(origin, direction, 1000.0);
    const Eigen::Vector2d hit = origin + std::min(expected, unknown) * direction;
    if ((hit.x() < 6.0 || hit.x() > 94.0) && (hit.y() < 6.0 || hit.y() > 55.0)) {
      continue;  // in a corner
    }
    if (unknown < expected) {
      EXPECT_TRUE(std::isnan(range)) << i;
    } else {
      ++hits;
      EXPECT_NEAR(range, expected, 1e-9) << i;
    }
  }
  EXPECT_GT(hits, 200);
  EXPECT_TRUE(std::isinf(walls.range(origin, {-1.0, 0.0}, 30.0))) << "farther than it reaches";
}

TEST(ImageWalls, AFewUnknownPixelsBeforeAWallAreNoEnd) {
  const auto range_through = [](int unknown) {
    const ImageWalls walls(image_of(30, 3, [=](const Cell& cell) {
      return cell.x == 20             ? CellState::kOccupied
             : cell.x >= 20 - unknown ? CellState::kUnknown
                                      : CellState::kFree;
    }));
    return walls.range({1.5, 1.5}, {1.0, 0.0}, 100.0);
  };
  EXPECT_NEAR(range_through(0), 18.5, 0.51);
  EXPECT_NEAR(range_through(3), 18.5, 0.51);
  EXPECT_TRUE(std::isnan(range_through(4)));
}

TEST(ImageWalls, AWallIsWhereItsPixelsLieOnALine) {
  const double slope = 0.3;
  const ImageWalls walls(image_of(80, 40, [=](const Cell& cell) {
    return cell.y == static_cast<int>(5.0 + slope * (cell.x + 0.5)) ? CellState::kOccupied
                                                                    : CellState::kFree;
  }));
  ASSERT_EQ(walls.walls().size(), 80U);
  const Eigen::Vector2d normal = Eigen::Vector2d(-slope, 1.0).normalized();
  double worst = 0.0;
  for (const SurfaceHit& wall : walls.walls()) {
    if (wall.position.x() > 4.0 && wall.position.x() < 76.0) {
      worst = std::max(worst, std::abs(normal.dot(wall.position - Eigen::Vector2d(0.0, 5.0))));
      EXPECT_GT(std::abs(normal.dot(wall.normal)), 0.99);
    }
  }
  EXPECT_LT(worst, 0.3) << "[pixels], of half a pixel that a pixel's centre is off";
}

/// A partition of which both faces were seen, and nothing between.
TEST(ImageWalls, TheTwoFacesOfAThinWallAreTwoLines) {
  const ImageWalls walls(image_of(60, 20, [=](const Cell& cell) {
    const int above = cell.y - 5 - cell.x / 10;  // of a slope that pixels show as steps
    return above == 0 || above == 3 ? CellState::kOccupied
           : above > 0 && above < 3 ? CellState::kUnknown
                                    : CellState::kFree;
  }));
  EXPECT_TRUE(std::all_of(walls.walls().begin(), walls.walls().end(),
                          [](const SurfaceHit& wall) { return wall.normal.norm() > 0.5; }));
}

TEST(ImageWalls, FacesLookTowardsFreeGround) {
  // A room's outer walls, two pixels thick at the left and below, in unknown ground; in it a
  // partition that both sides show as a line, and one of a single pixel.
  const ImageWalls walls(image_of(100, 60, [](const Cell& cell) {
    const bool is_outside = cell.x < 5 || cell.x > 94 || cell.y < 5 || cell.y > 54;
    const bool is_border = cell.x < 7 || cell.x == 94 || cell.y < 7 || cell.y == 54;
    const bool is_face = cell.x == 40 || cell.x == 43;
    const bool is_within = cell.x == 41 || cell.x == 42;
    return is_outside || (is_within && !is_border) ? CellState::kUnknown
           : is_border || is_face || cell.x == 70  ? CellState::kOccupied
                                                   : CellState::kFree;
  }));
  std::map<int, Eigen::Vector2d> sum_at;  // by column, half way up
  for (const SurfaceHit& face : walls.faces()) {
    if (face.position.y() > 20.0 && face.position.y() < 40.0) {
      sum_at.try_emplace(cell_index(face.position.x()), Eigen::Vector2d::Zero()).first->second +=
          face.normal / 20.0;
    }
  }
  const auto facing = [&](int column) { return sum_at.at(column).x(); };
  EXPECT_NEAR(facing(6), 2.0, 1e-6) << "two pixels, the line between them";
  EXPECT_NEAR(facing(40), -1.0, 1e-6);
  EXPECT_NEAR(facing(43), 1.0, 1e-6);
  EXPECT_NEAR(facing(70), 0.0, 1e-6) << "both sides fall into one cell";
  EXPECT_NEAR(facing(94), -1.0, 1e-6);
}

/// Two rooms with a door between them, 10 m by 6 m, and a thin wall.
TEST(Viewpoints, OneIsNearEachPlaceAndInItsSight) {
  const double resolution = 0.05;
  const ImageWalls walls(image_of(200, 120, [](const Cell& cell) {
    const bool is_border = cell.x == 0 || cell.x == 199 || cell.y == 0 || cell.y == 119;
    const bool is_between = cell.x == 90 && (cell.y < 50 || cell.y > 70);
    return is_border || is_between ? CellState::kOccupied : CellState::kFree;
  }));
  const std::vector<Cell> chosen = viewpoints(walls, resolution);
  for (int y = 8; y < 112; ++y) {
    for (int x = 8; x < 192; ++x) {
      if (std::abs(x - 90) < 8) {
        continue;
      }
      EXPECT_TRUE(std::any_of(chosen.begin(), chosen.end(),
                              [&](const Cell& point) {
                                const double apart =
                                    resolution * std::hypot(point.x - x, point.y - y);
                                return apart < 2.4 && walls.is_in_sight({x, y}, point);
                              }))
          << x << ' ' << y;
    }
  }
  EXPECT_LE(chosen.size(), 20U) << "of 60 m2, each of which sees 12";
  for (const Cell& point : chosen) {
    EXPECT_EQ(walls.state(point), CellState::kFree);
  }
}

TEST(Viewpoints, AreNoneWhereARobotHasNoRoom) {
  const ImageWalls walls(image_of(50, 5, [](const Cell& /*cell*/) { return CellState::kFree; }));
  EXPECT_TRUE(viewpoints(walls, 0.05).empty());
}

}  // namespace
}  // namespace matchbox_slam
