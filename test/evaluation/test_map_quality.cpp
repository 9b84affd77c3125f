#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/error_text.hpp"
#include "evaluation/map_quality.hpp"
#include "geometry/trajectory.hpp"

namespace matchbox_slam {
namespace {

/// A map to draw on; nothing is known at first. Cells count from the lower left one.
MapImage unknown_map(int width, int height) {
  MapImage map;
  map.width = width;
  map.height = height;
  map.pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                    MapImage::kUnknownPixel);
  return map;
}

/// Fills cells from (left, bottom) up to but without (right, top).
void fill(int left, int bottom, int right, int top, std::uint8_t pixel, MapImage& map) {
  for (int y = bottom; y < top; ++y) {
    for (int x = left; x < right; ++x) {
      map.pixels[static_cast<std::size_t>(map.height - 1 - y) *
                     static_cast<std::size_t>(map.width) +
                 static_cast<std::size_t>(x)] = pixel;
    }
  }
}

void add_wall(int left, int bottom, int right, int top, MapImage& map) {
  fill(left, bottom, right, top, MapImage::kOccupiedPixel, map);
}

/// Walls of one cell around a box, free within.
void add_room(int left, int bottom, int right, int top, MapImage& map) {
  add_wall(left, bottom, right, top, map);
  fill(left + 1, bottom + 1, right - 1, top - 1, MapImage::kFreePixel, map);
}

/// A room of 60 x 40 cells whose lower left corner cell is (20, 10).
MapImage one_room() {
  MapImage map = unknown_map(100, 70);
  add_room(20, 10, 80, 50, map);
  return map;
}

/// With a wall across, and in it a door of so many cells.
MapImage two_rooms(int door) {
  MapImage map = one_room();
  add_wall(50, 11, 51, 49, map);
  fill(50, 25, 51, 25 + door, MapImage::kFreePixel, map);
  return map;
}

/// All that map_server calls occupied, drawn anew at another place: as a SLAM does that lost its
/// way by so many cells.
MapImage doubled(const MapImage& map, int right, int up) {
  MapImage twice = map;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      if (map.state({x, y}) == CellState::kOccupied) {
        add_wall(x + right, y + up, x + right + 1, y + up + 1, twice);
      }
    }
  }
  return twice;
}

/// Turned to the left by a right angle.
MapImage turned(const MapImage& map) {
  MapImage result = unknown_map(map.height, map.width);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const int left = map.height - 1 - y;
      fill(left, x, left + 1, x + 1, map.pixel({x, y}), result);
    }
  }
  return result;
}

MapImage with_margin(const MapImage& map, int margin) {
  MapImage result = unknown_map(map.width + 2 * margin, map.height + 2 * margin);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      fill(x + margin, y + margin, x + margin + 1, y + margin + 1, map.pixel({x, y}), result);
    }
  }
  return result;
}

/// Bright is occupied, as negate says; what is unknown lies between the thresholds both ways.
MapImage negated(MapImage map) {
  map.negate = true;
  for (std::uint8_t& pixel : map.pixels) {
    pixel = static_cast<std::uint8_t>(255 - pixel);
  }
  return map;
}

/// Walls at odd angles, doubled, with specks: everything that counts may hang on a tie.
MapImage messy_map() {
  MapImage map = doubled(two_rooms(14), 4, 5);
  for (int i = 0; i < 30; ++i) {
    const int y = 15 + static_cast<int>(std::lround(0.6 * i));
    add_wall(24 + i, y, 25 + i, y + 1, map);
    add_wall((37 * i) % 90, (53 * i) % 50, (37 * i) % 90 + 2, (53 * i) % 50 + 2, map);
  }
  return map;
}

void expect_same_figures(const MapQuality& a, const MapQuality& b) {
  EXPECT_EQ(a.occupied_cells, b.occupied_cells);
  EXPECT_EQ(a.free_cells, b.free_cells);
  EXPECT_EQ(a.corners.size(), b.corners.size());
  EXPECT_EQ(a.enclosed_areas.size(), b.enclosed_areas.size());
}

TEST(MapQuality, OfARoomIsFourCornersAndOneArea) {
  const MapQuality quality = measure_map_quality(one_room());
  EXPECT_EQ(quality.occupied_cells, 2U * 60 + 2U * 38);
  EXPECT_EQ(quality.free_cells, 58U * 38);
  EXPECT_EQ(quality.known_cells(), 60U * 40);
  EXPECT_DOUBLE_EQ(quality.occupied_of_known(), 196.0 / 2400.0);
  EXPECT_DOUBLE_EQ(quality.occupied_of_free(), 196.0 / 2204.0);
  EXPECT_EQ(quality.corners.size(), 4U);
  EXPECT_EQ(quality.enclosed_areas.size(), 1U);
}

TEST(MapQuality, CornersAndAreasAreWhereTheyAreSeen) {
  const MapQuality quality = measure_map_quality(one_room());
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& corner : quality.corners) {
    sum += corner;
  }
  EXPECT_EQ(sum / 4.0, Eigen::Vector2d(50.0, 30.0));
  for (const Eigen::Vector2d& expected :
       {Eigen::Vector2d(20.5, 10.5), Eigen::Vector2d(79.5, 10.5), Eigen::Vector2d(20.5, 49.5),
        Eigen::Vector2d(79.5, 49.5)}) {
    double nearest = 1e9;
    for (const Eigen::Vector2d& corner : quality.corners) {
      nearest = std::min(nearest, (corner - expected).norm());
    }
    EXPECT_LT(nearest, 2.5) << expected.transpose();
  }
  ASSERT_EQ(quality.enclosed_areas.size(), 1U);
  EXPECT_EQ(quality.enclosed_areas[0].size(), 58U * 38);
  for (const Cell& cell : quality.enclosed_areas[0]) {
    EXPECT_EQ(one_room().state(cell), CellState::kFree) << cell.x << ' ' << cell.y;
  }
}

TEST(MapQuality, ADoorJoinsTwoRoomsAndAGapOfTwoCellsDoesNot) {
  EXPECT_EQ(measure_map_quality(two_rooms(0)).enclosed_areas.size(), 2U);
  EXPECT_EQ(measure_map_quality(two_rooms(2)).enclosed_areas.size(), 2U);
  EXPECT_EQ(measure_map_quality(two_rooms(3)).enclosed_areas.size(), 1U);
  EXPECT_EQ(measure_map_quality(two_rooms(0)).corners.size(), 6U);  // four, and two T's
}

TEST(MapQuality, ARoomThatIsOpenEnclosesNothing) {
  MapImage map = one_room();
  fill(20, 30, 21, 40, MapImage::kFreePixel, map);
  EXPECT_EQ(measure_map_quality(map).enclosed_areas.size(), 0U);
}

TEST(MapQuality, WallsCloseDiagonally) {
  MapImage map = unknown_map(60, 60);
  fill(30, 30, 31, 31, MapImage::kFreePixel, map);
  for (int i = 0; i < 20; ++i) {  // a square on its tip, its cells touching at their corners
    add_wall(10 + i, 30 + i, 11 + i, 31 + i, map);
    add_wall(10 + i, 30 - i, 11 + i, 31 - i, map);
    add_wall(50 - i, 30 + i, 51 - i, 31 + i, map);
    add_wall(50 - i, 30 - i, 51 - i, 31 - i, map);
  }
  add_wall(30, 10, 31, 11, map);
  add_wall(30, 50, 31, 51, map);
  EXPECT_EQ(measure_map_quality(map).enclosed_areas.size(), 1U);
}

TEST(MapQuality, TheEdgeOfTheImageIsNoWall) {
  MapImage map = unknown_map(40, 40);
  fill(0, 0, 40, 40, MapImage::kFreePixel, map);
  add_wall(0, 20, 40, 21, map);  // from edge to edge
  const MapQuality quality = measure_map_quality(map);
  EXPECT_EQ(quality.corners.size(), 0U);
  EXPECT_EQ(quality.enclosed_areas.size(), 0U);
}

TEST(MapQuality, DoubledWallsRaiseEveryFigure) {
  const MapQuality once = measure_map_quality(two_rooms(14));
  const MapQuality twice = measure_map_quality(doubled(two_rooms(14), 7, 12));
  EXPECT_GT(twice.occupied_of_known(), 1.5 * once.occupied_of_known());
  EXPECT_GT(twice.occupied_of_free(), 1.5 * once.occupied_of_free());
  EXPECT_GT(twice.corners.size(), once.corners.size());
  EXPECT_GT(twice.enclosed_areas.size(), once.enclosed_areas.size());
}

TEST(MapQuality, StraightWallsHaveNoCornersWhateverTheirAngle) {
  for (int degrees = 0; degrees <= 90; ++degrees) {
    const double angle = degrees * kPi / 180.0;
    const Eigen::Vector2d normal(-std::sin(angle), std::cos(angle));
    for (const double thickness : {1.0, 2.0, 3.0}) {
      MapImage map = unknown_map(120, 120);
      fill(119, 0, 120, 1, MapImage::kFreePixel, map);
      for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) {
          if (std::abs(normal.dot(Eigen::Vector2d(x - 60.3, y - 59.6))) <= 0.5 * thickness) {
            add_wall(x, y, x + 1, y + 1, map);
          }
        }
      }
      // Its two ends at the edge of the image may be corners.
      for (const Eigen::Vector2d& corner : measure_map_quality(map).corners) {
        EXPECT_GT((corner - Eigen::Vector2d(60, 60)).cwiseAbs().maxCoeff(), 50.0)
            << degrees << " degrees, " << thickness << " cells: " << corner.transpose();
      }
    }
  }
}

TEST(MapQuality, SpecksCountAsOccupiedOnly) {
  MapImage map = one_room();
  add_wall(40, 20, 42, 22, map);  // 4 cells
  add_wall(60, 40, 61, 41, map);
  const MapQuality quality = measure_map_quality(map);
  EXPECT_EQ(quality.occupied_cells, 196U + 5U);
  EXPECT_EQ(quality.corners.size(), 4U);
  EXPECT_EQ(quality.enclosed_areas.size(), 1U);
}

TEST(MapQuality, HolesInAWallAreNoAreas) {
  MapImage map = one_room();
  add_wall(30, 20, 40, 30, map);
  fill(34, 24, 37, 25, MapImage::kUnknownPixel, map);
  EXPECT_EQ(measure_map_quality(map).enclosed_areas.size(), 1U);
}

TEST(MapQuality, OneStrongSpotDoesNotHideTheOtherCorners) {
  MapImage map = unknown_map(160, 60);
  add_room(20, 10, 80, 50, map);
  // Thick walls respond tenfold: with a share of the highest value, the room would lose its
  // corners.
  add_wall(110, 20, 150, 22, map);
  add_wall(110, 20, 112, 50, map);
  const MapQuality quality = measure_map_quality(map);
  EXPECT_EQ(std::count_if(quality.corners.begin(), quality.corners.end(),
                          [](const Eigen::Vector2d& corner) { return corner.x() < 90.0; }),
            4);
}

TEST(MapQuality, DoesNotDependOnMarginTurnOrNegation) {
  for (const MapImage& map : {one_room(), two_rooms(14), messy_map()}) {
    const MapQuality quality = measure_map_quality(map);
    expect_same_figures(measure_map_quality(with_margin(map, 1)), quality);
    expect_same_figures(measure_map_quality(with_margin(map, 57)), quality);
    expect_same_figures(measure_map_quality(negated(map)), quality);
    MapImage turning = map;
    for (int quarter = 1; quarter < 4; ++quarter) {
      turning = turned(turning);
      expect_same_figures(measure_map_quality(turning), quality);
    }
  }
}

TEST(MapQuality, IsTheSameTwice) {
  const MapQuality first = measure_map_quality(messy_map());
  const MapQuality second = measure_map_quality(messy_map());
  EXPECT_EQ(first.corners, second.corners);
  EXPECT_EQ(first.enclosed_areas, second.enclosed_areas);
}

TEST(MapQuality, RefusesAMapWithoutFreeCells) {
  MapImage map = unknown_map(3, 2);
  EXPECT_EQ(error_text<EvaluationError>([&] { (void)measure_map_quality(map); }),
            "none of the map's 3 x 2 cells is free (0 are occupied), but quality is measured "
            "against the free ones; do negate and free_thresh fit the image?");
  fill(0, 0, 1, 1, MapImage::kFreePixel, map);
  EXPECT_EQ(measure_map_quality(map).occupied_of_known(), 0.0);
}

}  // namespace
}  // namespace matchbox_slam
