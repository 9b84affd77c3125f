#include "ros/clock_comparison.hpp"

#include <cmath>

#include "evaluation/error_statistics.hpp"
#include "ros/message_conversion.hpp"
#include "ros/transform_store.hpp"

namespace matchbox_slam {

namespace {

// Beyond 2^31 s no ros::Duration goes, and no clock is that wrong; stamps may be.
constexpr double kLargestOffset = 2e9;

}  // namespace

void ClockComparison::add_scan(const ros::Time& stamp, const ros::Time& arrival) {
  scans_.push_back(seconds_between(arrival, stamp));
}

void ClockComparison::add_transform(const geometry_msgs::TransformStamped& transform,
                                    const ros::Time& arrival) {
  Link& link = links_[without_leading_slash(transform.child_frame_id)];
  const geometry_msgs::Transform& t = transform.transform;
  const std::vector<double> place = {t.translation.x, t.translation.y, t.rotation.z, t.rotation.w};
  link.moves = link.moves || (!link.leads.empty() && place != link.place);
  link.place = place;
  link.leads.push_back(seconds_between(arrival, transform.header.stamp));
}

std::set<std::string> ClockComparison::moving() const {
  std::set<std::string> frames;
  for (const auto& [frame, link] : links_) {
    if (link.moves) {
      frames.insert(frame);
    }
  }
  return frames;
}

std::optional<double> ClockComparison::offset() const {
  std::vector<double> moving;
  std::vector<double> all;
  for (const auto& [name, link] : links_) {
    all.insert(all.end(), link.leads.begin(), link.leads.end());
    if (link.moves) {
      moving.insert(moving.end(), link.leads.begin(), link.leads.end());
    }
  }
  if (all.empty() || scans_.empty()) {
    return std::nullopt;
  }
  const double offset = quantile(moving.empty() ? all : moving, 0.5) - quantile(scans_, 0.5);
  return std::abs(offset) < kLargestOffset ? std::optional<double>(offset) : std::nullopt;
}

}  // namespace matchbox_slam
