#include "common/version.hpp"

namespace matchbox_slam {

std::string package_version() { return MATCHBOX_SLAM_VERSION; }

std::string version_text(const std::string& program) {
  return program + " of matchbox_slam " + package_version();
}

}  // namespace matchbox_slam
