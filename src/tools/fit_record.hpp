#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/slam/slam_engine.hpp"

namespace matchbox_slam {

/// How the scans of a run fitted the map, for what is told at its end: without truth these are the
/// signs that a map is not to be trusted.
class FitRecord {
 public:
  void add(const ScanOutcome& outcome);

  [[nodiscard]] std::size_t matched() const { return count_of(MatchStatus::kAccepted); }

  /// Scans at which the robot might have been anywhere: those that match do so in a map of their
  /// own.
  [[nodiscard]] std::size_t lost() const { return lost_; }
  /// At nine tenths of the scans or more.
  [[nodiscard]] bool is_mostly_lost() const;

  /// One text each, for people: that a tenth of the scans or more match nowhere; that for 5 % of
  /// the time, or for half a minute at a stretch, it was not sure where the robot is; that matches
  /// fit poorly in the median; that the pose jumps
  /// against the odometry. Empty: nothing speaks against the map.
  /// @param place_told_by  what says where the lasers are, for people.
  [[nodiscard]] std::vector<std::string> warnings(const std::string& place_told_by = "in tf") const;

 private:
  [[nodiscard]] std::size_t count_of(MatchStatus status) const;
  [[nodiscard]] std::string text_of_few_matches() const;
  [[nodiscard]] std::string text_of_doubt() const;
  [[nodiscard]] std::string text_of_poor_fit(const std::string& place_told_by) const;
  [[nodiscard]] std::string text_of_jumps(const std::string& place_told_by) const;

  std::size_t scans_ = 0;
  std::size_t lost_ = 0;
  std::map<MatchStatus, std::size_t> statuses_;
  std::vector<float> scores_;           ///< of accepted matches
  std::vector<float> evidences_;        ///< of a beam, likewise
  std::optional<Pose2> map_from_odom_;  ///< at the newest scan
  Pose2 last_odometry_;                 ///< where there was any
  bool has_secondary_lasers_ = false;
  std::size_t steps_ = 0;               ///< from scan to scan, soon after each other
  std::size_t jumps_ = 0;               ///< of these
  std::optional<double> first_stamp_;   ///< [s]
  double last_stamp_ = 0.0;             ///< [s]
  std::optional<double> unsure_since_;  ///< [s]
  double unsure_ = 0.0;                 ///< [s] in all
  double longest_ = 0.0;                ///< [s]
  double longest_since_ = 0.0;          ///< stamp [s]
};

}  // namespace matchbox_slam
