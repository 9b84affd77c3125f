#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sensor/point_surfaces.hpp"

namespace matchbox_slam {
namespace {

/// What a laser at the origin sees, beam by beam.
class Beams {
 public:
  Beams& add(double x, double y, const Eigen::Vector2d& normal = Eigen::Vector2d::Zero()) {
    points_.push_back({{x, y}, {0.0, 0.0}, normal, 0.1, false});
    return *this;
  }

  /// A wall on the right, seen from 5 to 15 m ahead.
  Beams& add_wall() {
    for (double x = 5.0; x < 15.0; x *= 1.1) {
      add(x, -1.2, Eigen::Vector2d::UnitY());
    }
    return *this;
  }

  [[nodiscard]] std::vector<Eigen::Vector2d> normals() const {
    std::vector<ScanPoint> points = points_;
    add_facing_pairs(points);
    std::vector<Eigen::Vector2d> normals;
    for (const ScanPoint& point : points) {
      normals.push_back(point.normal);
    }
    return normals;
  }

 private:
  std::vector<ScanPoint> points_;
};

TEST(AddFacingPairs, TwoBeamsThroughACrackTellWhichWayTheWallFaces) {
  const auto normals = Beams().add_wall().add(18.0, -1.36).add(18.01, -1.28).normals();
  for (const std::size_t from_end : {1U, 2U}) {
    const Eigen::Vector2d& normal = normals[normals.size() - from_end];
    EXPECT_NEAR(normal.norm(), 1.0, 1e-9);
    EXPECT_LT(normal.x(), -0.95) << "towards the laser";
  }
}

TEST(AddFacingPairs, OfThreeInARowEachHasItsNormal) {
  const auto normals = Beams().add(15.0, 0.0).add(15.0, 0.1).add(15.0, 0.2).normals();
  for (const Eigen::Vector2d& normal : normals) {
    EXPECT_NEAR(normal.x(), -1.0, 0.02);
  }
}

/// Where beams graze the wall beside the crack they are far apart, and tell nothing across it.
TEST(AddFacingPairs, WhatLiesOnTheLineOfTheWallBesideIsThatWall) {
  const auto normals = Beams().add_wall().add(18.0, -1.21).add(18.05, -1.19).normals();
  EXPECT_TRUE(normals[normals.size() - 1].isZero());
  EXPECT_TRUE(normals[normals.size() - 2].isZero());
}

TEST(AddFacingPairs, WhatIsObliqueOrTooNearOrTooFarToTellIsLeft) {
  const auto is_pair = [](double x, double y) {
    return !Beams().add(40.0, 0.0).add(40.0 + x, y).normals()[0].isZero();
  };
  EXPECT_FALSE(is_pair(0.1, 0.1)) << "oblique";
  EXPECT_FALSE(is_pair(0.0, 0.03)) << "noise is as large";
  EXPECT_FALSE(is_pair(0.0, 0.31)) << "two things";
  EXPECT_TRUE(is_pair(0.0, 0.29));
  EXPECT_TRUE(Beams().add(10.0, 0.0).add(10.0, 0.09).normals()[0].isZero())
      << "half a degree apart they meet two things, too";
}

TEST(AddFacingPairs, NormalsThatThereAreStay) {
  const Eigen::Vector2d normal(0.6, 0.8);
  const auto normals = Beams().add(15.0, 0.0, normal).add(15.0, 0.1).add(15.0, 0.2).normals();
  EXPECT_EQ(normals[0], normal);
  EXPECT_NEAR(normals[1].x(), -1.0, 0.02);
}

}  // namespace
}  // namespace matchbox_slam
