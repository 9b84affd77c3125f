#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "odometry/scan_motion.hpp"
#include "sensor/scan_timing.hpp"
#include "sensor/sweep_time_choice.hpp"

namespace matchbox_slam {

/// How long the sweeps of a robot's lasers take (SweepTimeChoice). How the robot moves meanwhile
/// odometry tells; without it each laser's own scans (ScanMotion), until they have told their
/// sweep.
class SweepTimes {
 public:
  /// @param shown       [s] by laser: their sweeps, as scans have shown them before.
  /// @param projection  as the scans are projected afterwards.
  /// @param has_odometry  that tells how the base drives, and not only how it turns.
  SweepTimes(const SweepTimeSetting& setting, std::map<int, double> shown,
             ProjectionOptions projection, bool has_odometry)
      : setting_(setting),
        shown_(std::move(shown)),
        projection_(std::move(projection)),
        has_odometry_(has_odometry) {}

  [[nodiscard]] bool has_odometry() const { return has_odometry_; }

  /// As SweepTimeChoice::note_pose, where there is odometry.
  void note_pose(int laser, double stamp, const Pose2& odom_from_base,
                 const std::function<std::optional<Pose2>(double stamp)>& odom_from_base_at) {
    choice_of(laser).note_pose(stamp, odom_from_base, odom_from_base_at);
  }

  /// As SweepTimeChoice::time_increment.
  [[nodiscard]] double time_increment(int laser, const LaserScan& as_sent, double sent_scan_time) {
    return choice_of(laser).time_increment(as_sent, sent_scan_time);
  }

  /// The scan as it is used. Throws as LaserOdometry::process.
  /// @param sent_increment  [s] between beams, by the message.
  void add(const ScanInput& input, double sent_increment);

  /// Whether scans of any laser may still show its sweep, of those that have sent one.
  [[nodiscard]] bool is_any_open() const;
  /// What scans have shown so far, by laser.
  [[nodiscard]] std::map<int, ShownSweep> shown() const;

  /// What was decided of a laser since the last call, for people; empty: nothing.
  [[nodiscard]] std::string take_news(int laser) { return choice_of(laser).take_news(); }

  /// Stamps begin anew.
  void forget();

 private:
  SweepTimeChoice& choice_of(int laser);

  SweepTimeSetting setting_;
  std::map<int, double> shown_;
  ProjectionOptions projection_;
  bool has_odometry_;
  std::map<int, SweepTimeChoice> choices_;  ///< by laser, as the next
  std::map<int, ScanMotion> motions_;
};

}  // namespace matchbox_slam
