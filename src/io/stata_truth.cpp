#include "io/stata_truth.hpp"

#include <fmt/core.h>

#include <cmath>
#include <vector>

#include "io/text_columns.hpp"
#include "matchbox_slam/common/parameters.hpp"

namespace matchbox_slam {
namespace {

const TextFormat kStataFormat{
    {"stamp", "x", "y", "theta"},
    " between commas; ground truth of MIT Stata has 4: stamp,x,y,theta (a TUM "
    "trajectory has 8, between blanks)",
    ','};

StampedPose2 stata_pose(const std::vector<double>& row, const TextPlace& place) {
  constexpr double kMicrosecondsPerSecond = 1e6;
  if (row[0] != std::floor(row[0])) {
    place.fail(fmt::format("stamp is '{}'; ground truth of MIT Stata has whole microseconds",
                           to_string(row[0])));
  }
  return {row[0] / kMicrosecondsPerSecond, {row[1], row[2], wrap_angle(row[3])}};
}

}  // namespace

bool looks_like_stata_truth(const std::string& text) { return has_separator(text, ','); }

Trajectory parse_stata_truth(const std::string& text, const std::string& source) {
  return read_trajectory(text, source, kStataFormat, stata_pose);
}

}  // namespace matchbox_slam
