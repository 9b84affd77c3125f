#include "io/image_views.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "map/image_viewpoints.hpp"
#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

constexpr int kBeams = 720;
constexpr double kReach = 30.0;  // [m]

/// As of a laser in the base.
/// @param origin   [pixels]
/// @param heading  of the base in the image [rad].
MeasuredScan view_from(const Eigen::Vector2d& origin, double heading, const ImageWalls& walls,
                       double resolution) {
  MeasuredScan view;
  view.is_of_image = true;
  view.scan.angle_min = -kPi;
  view.scan.angle_increment = 2.0 * kPi / kBeams;
  view.scan.range_max = kReach;
  view.scan.ranges.reserve(kBeams);
  for (int i = 0; i < kBeams; ++i) {
    const double angle = heading + view.scan.angle_min + i * view.scan.angle_increment;
    const double range =
        walls.range(origin, {std::cos(angle), std::sin(angle)}, kReach / resolution);
    view.scan.ranges.push_back(static_cast<float>(resolution * range));
  }
  return view;
}

/// A search takes one key scan of those that are near each other and look the same way, though a
/// wall may be between them: so of those no two look the same way.
double free_heading(const Eigen::Vector2d& place, const PlacedScans& others) {
  constexpr double kSamePlaceDistance = 1.1;  // [m], more than spread_out's
  constexpr std::array kHeadings = {0.0, 0.5 * kPi, kPi, -0.5 * kPi};
  const auto is_free = [&](double heading) {
    return std::none_of(others.begin(), others.end(), [&](const PlacedScan& other) {
      return (other.map_from_base.translation() - place).norm() < kSamePlaceDistance &&
             std::abs(wrap_angle(other.map_from_base.theta - heading)) < 0.25 * kPi;
    });
  };
  const auto* free = std::find_if(kHeadings.begin(), kHeadings.end(), is_free);
  return free == kHeadings.end() ? kHeadings.front() : *free;
}

}  // namespace

KeyScans image_views(const ImageWalls& walls, double resolution, const Pose2& map_from_image) {
  KeyScans views;
  const std::vector<Cell> places = viewpoints(walls, resolution);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Eigen::Vector2d pixel(places[i].x + 0.5, places[i].y + 0.5);
    const Eigen::Vector2d place = map_from_image * Eigen::Vector2d(resolution * pixel);
    const double heading = free_heading(place, views.all());
    MeasuredScan view =
        view_from(pixel, wrap_angle(heading - map_from_image.theta), walls, resolution);
    view.scan.stamp = image_stamp(i, places.size());
    views.add(std::move(view), 0, {place.x(), place.y(), heading});
  }
  return views;
}

}  // namespace matchbox_slam
