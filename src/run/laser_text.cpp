#include "run/laser_text.hpp"

#include <fmt/core.h>

#include <cmath>

#include "common/number_text.hpp"

namespace matchbox_slam {
namespace {

constexpr const char* kLeads =
    "; of scan_topics the first one leads: if this is the better laser, name it first";

std::string millimetres(double metres) { return fmt::format("{:.0f} mm", 1e3 * metres); }

std::string degrees(double radians) {
  return fmt::format("{:.1f} deg", radians_to_degrees(radians));
}

std::string agreeing(const SecondaryLaser& laser) {
  return fmt::format("{} of {} matches agree", laser.mount.agreeing(),
                     laser.mount.samples().size());
}

}  // namespace

LaserPlace place_of(const SecondaryLaser& laser) {
  const Eigen::Vector3d at_rest = Eigen::Vector3d::Zero();
  const Pose2 correction = laser.mount.correction(at_rest);
  LaserPlace place;
  place.base_from_laser = correction * laser.base_from_laser;
  Eigen::Matrix3d by_correction = Eigen::Matrix3d::Identity();
  by_correction.topRightCorner<2, 1>() << -laser.base_from_laser.y, laser.base_from_laser.x;
  place.sigma =
      (by_correction * laser.mount.correction_covariance(at_rest) * by_correction.transpose())
          .diagonal()
          .cwiseSqrt();
  place.from_tf =
      (place.base_from_laser.translation() - laser.base_from_laser.translation()).norm();
  place.turned = correction.theta;
  place.delay = laser.mount.value()(3);
  place.delay_sigma = std::sqrt(laser.mount.covariance()(3, 3));
  return place;
}

LaserUse use_of(const SecondaryLaser& laser) {
  if (laser.is_used) {
    return LaserUse::kUsed;
  }
  return laser.mount.is_contradictory() ? LaserUse::kContradictory : LaserUse::kUnsure;
}

std::string text_of_robot_beams(const std::vector<double>& sectors,
                                const std::vector<double>& masked, const std::string& set) {
  std::string list;
  for (const std::vector<double>* part : {&masked, &sectors}) {
    for (const double angle : *part) {
      list += (list.empty() ? "" : ",") + fixed_text(angle, 3);
    }
  }
  return fmt::format(
      "beams end on the robot itself: in {}{} the range stays the same wherever it is; to leave "
      "them out of every laser's scans {}scan/masked_angles=[{}]",
      sectors.size() / 2, sectors.size() == 2 ? " sector" : " sectors", set, list);
}

std::string text_of_few_returns(std::optional<std::size_t> returns) {
  // Of the zoo's drives 32 beams end with 0.28 m in the mean, odometry with 0.33
  // (benchmark/reports/current/CONTRADICTIONS.md).
  constexpr std::size_t kMinReturns = 40;
  if (!returns || *returns >= kMinReturns) {
    return "";
  }
  return fmt::format(
      "scans have {} returns in the median; with fewer than {} the map may be no better than "
      "odometry. Look whether scan/* or the driver leaves readings out, or "
      "whether scans are parts of a turn: scan/join_parts",
      *returns, kMinReturns);
}

std::string text_of(const SecondaryLaser& laser, const std::string& topic) {
  const LaserPlace place = place_of(laser);
  const Pose2& pose = place.base_from_laser;
  switch (use_of(laser)) {
    case LaserUse::kUsed:
      return fmt::format(
          "the laser of {} is {} and {} from where tf has it, at x {:.3f} +- {:.3f} m, y {:.3f} +- "
          "{:.3f} m, yaw {:.2f} +- {:.2f} deg on the base, its scans {:.0f} +- {:.0f} ms after "
          "their stamps; it is used so",
          topic, millimetres(place.from_tf), degrees(std::abs(place.turned)), pose.x,
          place.sigma.x(), pose.y, place.sigma.y(), radians_to_degrees(pose.theta),
          radians_to_degrees(place.sigma.z()), 1e3 * place.delay, 1e3 * place.delay_sigma);
    case LaserUse::kContradictory:
      return fmt::format(
          "the laser of {} contradicts the first one, which alone is used: no more than {} on "
          "where it is; do both see the same walls, is tf right to 0.1 m and 5 deg, are the "
          "stamps?{}",
          topic, agreeing(laser), kLeads);
    case LaserUse::kUnsure:
      break;
  }
  return fmt::format(
      "the laser of {} is not used, as it is not sure where it is on the base: {}; it has to see "
      "what the first one has just seen, while the robot drives and turns{}",
      topic, agreeing(laser), kLeads);
}

}  // namespace matchbox_slam
