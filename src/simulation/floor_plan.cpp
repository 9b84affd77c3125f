#include "simulation/floor_plan.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {
namespace {

bool is_any_nearer(const std::vector<WallSegment>& lines, const std::vector<WallSegment>& others,
                   double limit) {
  return std::any_of(lines.begin(), lines.end(), [&](const WallSegment& line) {
    return std::any_of(others.begin(), others.end(),
                       [&](const WallSegment& other) { return distance(line, other) < limit; });
  });
}

}  // namespace

Eigen::Vector2d polar(double radius, double angle) {
  return radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

Corners box(const Eigen::Vector2d& centre, const Eigen::Vector2d& size, double angle) {
  const Pose2 pose{centre.x(), centre.y(), angle};
  const Eigen::Vector2d half = 0.5 * size;
  return {pose * Eigen::Vector2d(-half.x(), -half.y()), pose * Eigen::Vector2d(half.x(), -half.y()),
          pose * Eigen::Vector2d(half.x(), half.y()), pose * Eigen::Vector2d(-half.x(), half.y())};
}

Corners regular_polygon(const Eigen::Vector2d& centre, double radius, int corners, double angle) {
  Corners points;
  for (int i = 0; i < corners; ++i) {
    const double direction = angle + 2.0 * kPi * i / corners;
    points.emplace_back(centre +
                        radius * Eigen::Vector2d(std::cos(direction), std::sin(direction)));
  }
  return points;
}

std::vector<WallSegment> open_line(const Corners& corners) {
  std::vector<WallSegment> lines;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    lines.push_back({corners[i - 1], corners[i]});
  }
  return lines;
}

std::vector<WallSegment> outline(const Corners& corners) {
  std::vector<WallSegment> lines = open_line(corners);
  lines.push_back({corners.back(), corners.front()});
  return lines;
}

std::vector<WallSegment> with_surface(std::vector<WallSegment> lines, const WallSurface& surface) {
  for (WallSegment& line : lines) {
    line.surface = surface;
  }
  return lines;
}

FloorPlan::FloorPlan(Route route)
    : route_(std::move(route)), route_lines_(open_line(route_.waypoints)) {}

void FloorPlan::add(const std::vector<WallSegment>& lines) {
  segments_.insert(segments_.end(), lines.begin(), lines.end());
}

void FloorPlan::add_wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double thickness,
                         std::vector<double> doors, double door_width) {
  const double length = (to - from).norm();
  const Eigen::Vector2d along = (to - from) / length;
  const double angle = std::atan2(along.y(), along.x());
  std::sort(doors.begin(), doors.end());
  doors.push_back(length + 0.5 * door_width);
  double start = 0.0;
  for (const double door : doors) {
    const double end = door - 0.5 * door_width;
    add(outline(box(from + 0.5 * (start + end) * along, {end - start, thickness}, angle)));
    start = door + 0.5 * door_width;
  }
}

bool FloorPlan::is_clear(const std::vector<WallSegment>& lines, double clearance,
                         double gap) const {
  return !is_any_nearer(lines, route_lines_, clearance) && !is_any_nearer(lines, thing_lines_, gap);
}

void FloorPlan::add_walking(const std::vector<WallSegment>& lines, const Walk& walk) {
  WallSurface walking;
  walking.walk = walks_.size();
  add(with_surface(lines, walking));
  walks_.push_back(walk);
}

bool FloorPlan::add_if_clear(const std::vector<WallSegment>& lines, double clearance, double gap,
                             const std::optional<Eigen::Vector2d>& hinge) {
  if (!is_clear(lines, clearance, gap)) {
    return false;
  }
  things_.push_back({segments_.size(), segments_.size() + lines.size(), hinge});
  add(lines);
  thing_lines_.insert(thing_lines_.end(), lines.begin(), lines.end());
  return true;
}

}  // namespace matchbox_slam
