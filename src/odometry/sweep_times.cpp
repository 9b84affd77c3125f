#include "odometry/sweep_times.hpp"

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

void SweepTimes::forget() {
  choices_.clear();
  motions_.clear();
}

}  // namespace matchbox_slam
