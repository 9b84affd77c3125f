#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "io/image_views.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/geometry/transform2.hpp"

namespace matchbox_slam {
namespace {

/// A room of 12 m x 8 m whose walls are one pixel thick.
MapImage image_of_room() {
  MapImage image;
  image.width = 240;
  image.height = 160;
  image.pixels.assign(std::size_t{240} * 160, MapImage::kFreePixel);
  for (int y = 0; y < 160; ++y) {
    for (int x = 0; x < 240; ++x) {
      if (x == 0 || y == 0 || x == 239 || y == 159) {
        image.pixels[240 * static_cast<std::size_t>(y) + static_cast<std::size_t>(x)] =
            MapImage::kOccupiedPixel;
      }
    }
  }
  return image;
}

TEST(ImageViews, SeeTheWallsWhereTheyAreInTheMap) {
  const MapImage image = image_of_room();
  const Pose2 map_from_image{-3.0, 20.0, 0.7};
  const KeyScans views = image_views(ImageWalls(image), image.resolution, map_from_image);
  ASSERT_GT(views.size(), 4U);
  const Transform2 to_image(map_from_image.inverse());
  std::set<double> stamps;
  for (const PlacedScan& view : views.all()) {
    stamps.insert(view.scan->stamp());
    EXPECT_TRUE(view.scan->is_of_image());
    const Transform2 to_map(view.map_from_base);
    EXPECT_GT(view.scan->points()->points.size(), 700U);
    for (const ScanPoint& point : view.scan->points()->points) {
      const Eigen::Vector2d seen = to_image * Eigen::Vector2d(to_map * point.position);
      const double off = std::min({std::abs(seen.x() - 0.025), std::abs(seen.x() - 11.975),
                                   std::abs(seen.y() - 0.025), std::abs(seen.y() - 7.975)});
      EXPECT_LT(off, 0.03) << seen.transpose();
    }
  }
  EXPECT_EQ(stamps.size(), views.size());
}

TEST(ImageViews, AreToldByWhatTheyAreAndNotByTheirStamps) {
  MeasuredScan scan;
  scan.scan.ranges = {1.0F, 1.0F};
  scan.scan.stamp = -5.0;
  KeyScans keys;
  keys.add(scan, 0, {});
  scan.is_of_image = true;
  keys.add(scan, 0, {});
  EXPECT_FALSE(keys.all()[0].scan->is_of_image());
  EXPECT_TRUE(keys.all()[1].scan->is_of_image()) << "though all else is alike";
  EXPECT_TRUE(KeyScan(*keys.all()[1].scan, 7).is_of_image()) << "by another number, too";
}

/// Else a search takes one of them alone.
TEST(ImageViews, ThoseNearEachOtherLookDifferentWays) {
  MapImage image = image_of_room();
  for (int y = 0; y < 160; ++y) {  // rooms of 0.8 m side by side
    for (int x = 0; x < 240; x += 16) {
      image.pixels[240 * static_cast<std::size_t>(y) + static_cast<std::size_t>(x)] =
          MapImage::kOccupiedPixel;
    }
  }
  const KeyScans views = image_views(ImageWalls(image), image.resolution, {});
  int near = 0;
  for (const PlacedScan& one : views.all()) {
    for (const PlacedScan& other : views.all()) {
      const Pose2 apart = one.map_from_base.inverse() * other.map_from_base;
      if (one.scan != other.scan && apart.translation().norm() < 1.0) {
        ++near;
        EXPECT_GE(std::abs(apart.theta), 0.25 * kPi);
      }
    }
  }
  EXPECT_GT(near, 10);
}

}  // namespace
}  // namespace matchbox_slam
