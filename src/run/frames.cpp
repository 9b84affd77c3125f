#include "run/frames.hpp"

#include <fmt/core.h>

#include <map>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {

std::string without_leading_slash(const std::string& frame) {
  return !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
}

void check_frames(const RunOptions& options) {
  std::map<std::string, std::string> names;
  const auto add = [&](const std::string& frame, const std::string& name) {
    const auto [other, is_new] = names.emplace(frame, name);
    if (!is_new && !frame.empty()) {
      throw ConfigurationError(fmt::format(
          "{}: '{}' is not allowed; allowed: a frame other than {}", name, frame, other->second));
    }
  };
  add(options.map_frame, "map_frame");
  add(options.base_frame, "base_frame");
  if (options.use_odometry) {
    add(options.odom_frame, "odom_frame");
  }
}

std::string text_of_swapped_frames(const std::string& base_frame, const std::string& odom_frame) {
  return fmt::format("odometry frame '{}' lies below base frame '{}' in tf; are the two swapped?",
                     odom_frame, base_frame);
}

}  // namespace matchbox_slam
