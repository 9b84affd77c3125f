#include "run/start_map.hpp"

#include "matchbox_slam/io/saved_map.hpp"

namespace matchbox_slam {

MapStart read_start_map(const std::string& path, const SlamSetup& setup) {
  constexpr double kPosition = 0.3;  // [m]
  constexpr double kHeading = 0.2;   // [rad]
  MapStart start = read_map_start(path, setup.engine);
  if (start.key_scans.empty()) {
    start.map_from_base = {setup.run.start_x, setup.run.start_y, wrap_angle(setup.run.start_theta)};
  }
  start.covariance +=
      Eigen::Vector3d(kPosition * kPosition, kPosition * kPosition, kHeading * kHeading)
          .asDiagonal();
  return start;
}

}  // namespace matchbox_slam
