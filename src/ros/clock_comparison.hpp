#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace matchbox_slam {

/// Offsets between clocks below this [s] are delays in the drivers and no difference.
constexpr double kMinToldClockOffset = 1.0;

/// Compares the clock that stamps scans with the one that stamps tf, by how much stamps are ahead
/// of the time at which the messages arrived or were recorded. Links that move count, where there
/// are any: drivers stamp links that never change ahead of their time.
class ClockComparison {
 public:
  void add_scan(const ros::Time& stamp, const ros::Time& arrival);
  void add_transform(const geometry_msgs::TransformStamped& transform, const ros::Time& arrival);

  /// Child frames of links whose place changed.
  [[nodiscard]] std::set<std::string> moving() const;

  /// To be added to the stamps of scans so that they agree with tf's [s], in the median. None
  /// without scans or transforms.
  [[nodiscard]] std::optional<double> offset() const;

 private:
  struct Link {
    std::vector<double> place;
    std::vector<double> leads;
    bool moves = false;
  };

  std::vector<double> scans_;
  std::map<std::string, Link> links_;
};

}  // namespace matchbox_slam
