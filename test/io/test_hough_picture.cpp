#include <gtest/gtest.h>

#include <cmath>

#include "io/hough_picture.hpp"

namespace matchbox_slam {
namespace {

PointScan wall_at(double angle) {
  const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
  PointScan scan;
  for (int i = -50; i <= 50; ++i) {
    ScanPoint point;
    point.position = 2.0 * normal + 0.05 * i * Eigen::Vector2d(-normal.y(), normal.x());
    point.origin = Eigen::Vector2d::Zero();
    scan.points.push_back(point);
  }
  return scan;
}

int darkest_column(const Picture& picture, int top, int bottom) {
  int at = 0;
  int least = 255;
  for (int x = 13; x < picture.width() - 13; ++x) {
    for (int y = top; y < bottom; ++y) {
      if (picture.color_at(x, y).red < least) {
        least = picture.color_at(x, y).red;
        at = x;
      }
    }
  }
  return at;
}

TEST(HoughPicture, ShowsAWallAsADarkCellAtItsAngle) {
  const Picture picture = draw_hough_domains(wall_at(kPi / 4.0), wall_at(kPi / 2.0), {});
  // A panel is 900 pixels for half a circle; the first begins at (12, 38), the second at (12, 436).
  EXPECT_NEAR(darkest_column(picture, 40, 396), 12 + 225, 6);
  EXPECT_NEAR(darkest_column(picture, 438, 794), 12 + 450, 6);
}

TEST(HoughPicture, IsDrawnOfNothingToo) {
  const Picture picture = draw_hough_domains({}, {}, {});
  EXPECT_GT(picture.width(), 900);
}

}  // namespace
}  // namespace matchbox_slam
