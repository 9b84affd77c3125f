#include "matchbox_slam/slam/engine_state.hpp"

#include <string>

namespace matchbox_slam {

void EngineState::begin_anew(const Pose2& map_from_base, const Eigen::Matrix3d& covariance) {
  MotionState at_rest;  // made first: the arguments may be the present motion's own
  at_rest.fixed_from_base = map_from_base;
  at_rest.covariance = covariance;
  motion = at_rest;
  last_inserted.clear();
  localization.hypotheses = {};
  localization.active = 0;
  localization.search = {};
  local_map.reset();
  map.field.render();  // as it is matched against from now on
  if (loops.pending) {
    loops.pending->is_abandoned = true;
  }
  is_moved = false;
  is_continued = false;
  secondary_lasers = {};  // what tf said may have been put right
}

void EngineState::shift_clock(double seconds) {
  if (motion.stamp) {
    *motion.stamp += seconds;
  }
  if (motion.fix) {
    motion.fix->stamp += seconds;
  }
  if (motion.calibration.stretch) {
    motion.calibration.stretch->stamp += seconds;
  }
  for (MapComponent& component : localization.components) {
    component.begin += seconds;
  }
  localization.search.stamp += seconds;
  secondary_lasers.shift_clock(seconds);
}

void check_map(const SlamMap& map, const EngineOptions& options) {
  const auto require = [](const std::string& name, double wanted, double made) {
    if (wanted != made) {
      throw ConfigurationError(name + ": " + to_string(wanted) +
                               " is not allowed with a map that was made with " + to_string(made) +
                               "; allowed: the same, or a new map");
    }
  };
  require("map/resolution", options.map.resolution, map.field.geometry().resolution());
  require("field/sigma", options.field.sigma, map.field.options().sigma);
  require("field/reach", options.field.reach, map.field.options().reach);
}

}  // namespace matchbox_slam
