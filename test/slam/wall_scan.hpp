#pragma once

#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// A piece of a straight wall, 1 m to the left of the robot and along its way [m].
inline PointScan wall_between(double from, double to) {
  PointScan scan;
  for (double x = from; x <= to; x += 0.05) {
    ScanPoint point{{x, 1.0}};
    point.normal = {0.0, -1.0};
    point.weight = 0.05;
    scan.points.push_back(point);
  }
  return scan;
}

}  // namespace matchbox_slam
