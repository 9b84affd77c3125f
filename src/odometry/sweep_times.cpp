#include "odometry/sweep_times.hpp"

#include <algorithm>

namespace matchbox_slam {

void SweepTimes::add(const ScanInput& input, double sent_increment) {
  SweepTimeChoice& choice = choice_of(input.laser);
  if (has_odometry_) {
    choice.add(input.scan, sent_increment, input.base_from_laser, input.odometry->odom_from_base);
    return;
  }
  if (choice.is_final()) {
    motions_.erase(input.laser);
  }
  if (!choice.is_undecided()) {
    return;
  }
  ScanMotion& motion = motions_.try_emplace(input.laser, projection_).first->second;
  if (const std::optional<Pose2> odom_from_base = motion.add(input)) {
    choice.note_pose(input.scan.stamp, *odom_from_base,
                     [&](double stamp) { return motion.odom_from_base_at(stamp); });
    choice.add(input.scan, sent_increment, input.base_from_laser, *odom_from_base);
  }
}

SweepTimeChoice& SweepTimes::choice_of(int laser) {
  const auto shown = shown_.find(laser);
  const std::optional<double> sweep =
      shown != shown_.end() ? std::optional(shown->second) : std::nullopt;
  return choices_.try_emplace(laser, setting_, sweep).first->second;
}

bool SweepTimes::is_any_open() const {
  return std::any_of(choices_.begin(), choices_.end(),
                     [](const auto& choice) { return choice.second.is_open(); });
}

std::map<int, ShownSweep> SweepTimes::shown() const {
  std::map<int, ShownSweep> all;
  for (const auto& [laser, choice] : choices_) {
    if (std::optional<ShownSweep> shown = choice.shown()) {
      all.emplace(laser, *std::move(shown));
    }
  }
  return all;
}

void SweepTimes::forget() {
  choices_.clear();
  motions_.clear();
}

}  // namespace matchbox_slam
