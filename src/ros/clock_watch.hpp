#pragma once

#include <ros/time.h>
#include <tf2_msgs/TFMessage.h>

#include <optional>
#include <string>

#include "ros/clock_comparison.hpp"

namespace matchbox_slam {

/// Watches the first seconds of scans and transforms as they arrive, to tell whether their clocks
/// differ.
class ClockWatch {
 public:
  /// @param map_frame  whose links do not count, without leading slash: they are our own.
  explicit ClockWatch(std::string map_frame) : map_frame_(std::move(map_frame)) {}

  /// False once `conclude` has given its answer.
  [[nodiscard]] bool is_watching() const { return is_watching_; }

  void add_scan(const ros::Time& stamp, const ros::Time& arrival);
  void add_transforms(const tf2_msgs::TFMessage& message, const ros::Time& arrival);

  /// Once enough has arrived: what to add to the stamps of scans [s], 0 where the clocks agree, or
  /// where no transforms come to compare with. None: not yet, or told already.
  [[nodiscard]] std::optional<double> conclude(const ros::Time& now);

 private:
  std::string map_frame_;
  bool is_watching_ = true;
  std::optional<ros::Time> first_scan_;
  ClockComparison clocks_;
};

}  // namespace matchbox_slam
