#include "matchbox_slam/lasers/secondary_lasers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matching/rendered_map.hpp"
#include "matching/wide_search.hpp"

namespace matchbox_slam {
namespace {

constexpr double kMaxSilence = 0.5;  // [s], as scans wait for those of other lasers
constexpr int kMaxSilentScans = 5;   // a guess: half and double were not tried

Eigen::Isometry3d in_space(const Pose2& pose) {
  return Eigen::Translation3d(pose.x, pose.y, 0.0) *
         Eigen::AngleAxisd(pose.theta, Eigen::Vector3d::UnitZ());
}

Pose2 in_plane(const Eigen::Isometry3d& pose) {
  const Eigen::Vector3d ahead = pose.linear().col(0);
  return {pose.translation().x(), pose.translation().y(), std::atan2(ahead.y(), ahead.x())};
}

/// What a laser saw lately, where the map's drift since does not show.
PlacedScans newest_of(int laser, const PlacedScans& keys, std::size_t most) {
  PlacedScans newest;
  for (auto key = keys.rbegin(); key != keys.rend() && newest.size() < most; ++key) {
    if (key->scan->laser() == laser) {
      newest.push_back(*key);
    }
  }
  return newest;
}

/// The part of a scan that lies where something was seen, walls or free ground.
PointScan seen_part(const PointScan& scan, const Pose2& map_from_base, const SlamMap& map) {
  PointScan part;
  part.stamp = scan.stamp;
  for (const ScanPoint& point : scan.points) {
    const Eigen::Vector2d place = map_from_base * point.position;
    if (!place.allFinite()) {
      continue;
    }
    const Cell cell = map.field.geometry().cell_at(place);
    if (map.occupancy.is_known(cell) || map.field.distance(cell) < LikelihoodField::kFar) {
      part.points.push_back(point);
    }
  }
  return part;
}

/// A match that says where the scan is in all three directions.
std::optional<MatchResult> match_near(const PointScan& scan, const Pose2& expected, bool is_found,
                                      const LikelihoodField& field) {
  // How far it may be from tf, or from where it was found: [m], [rad].
  const double xy = is_found ? 0.03 : 0.1;
  const double theta = is_found ? 0.02 : 0.06;
  // Guesses; half or double changes no byte of a drive whose second laser tf has 36 mm and 1.2
  // degrees off (benchmark/reports/current/CONSTANTS.md), but for the score: of twice as much
  // there is none.
  constexpr double kWindow = 2.5;  // sigmas
  constexpr double kLeastScore = 0.6;
  constexpr double kMostRival = 0.9;
  constexpr double kMostTheta = 0.012;  // [rad]
  const PlacedScans none;
  const MatchResult match =
      search_exactly({scan, expected, covariance_of(xy, theta), field, none, 0});
  const Eigen::Vector3d moved = difference(match.map_from_base, expected);
  const bool is_near =
      moved.head<2>().norm() <= kWindow * xy && std::abs(moved.z()) <= kWindow * theta;
  const bool is_clear = match.accepted() && match.score >= kLeastScore &&
                        match.rival_share < kMostRival && match.unconstrained_directions.empty() &&
                        match.covariance(2, 2) < kMostTheta * kMostTheta;
  return is_near && is_clear ? std::optional<MatchResult>(match) : std::nullopt;
}

}  // namespace

bool SecondaryLasers::select_primary(const ScanInput& input, const std::optional<double>& newest) {
  if (input.laser != 0) {
    lasers_[input.laser].base_from_laser = in_plane(input.base_from_laser);
  }
  if (input.laser != 0 && input.laser != primary_.laser) {
    if (primary_.others == 0) {
      primary_.silent_since = newest.value_or(input.scan.stamp);
    }
    ++primary_.others;
    if (primary_.others <= kMaxSilentScans ||
        input.scan.stamp - primary_.silent_since <= kMaxSilence) {
      return false;
    }
    lasers_[input.laser].waiting.reset();
  }
  primary_ = {input.laser, 0, 0.0};
  return true;
}

Eigen::Isometry3d SecondaryLasers::base_from_laser(const ScanInput& input,
                                                   const Eigen::Vector3d& velocity) const {
  const auto laser = lasers_.find(input.laser);
  if (laser == lasers_.end() || !laser->second.is_used) {
    return input.base_from_laser;
  }
  return in_space(laser->second.mount.correction(velocity)) * input.base_from_laser;
}

void SecondaryLasers::wait(const ScanInput& input, const Eigen::Vector3d& velocity,
                           const Pose2& newest_from_base, const Pose2& motion,
                           const ProjectionOptions& options) {
  SecondaryLaser& laser = lasers_.at(input.laser);
  laser.waiting.reset();
  if (laser.is_used) {
    laser.waiting = SecondaryScan{
        {input.scan, base_from_laser(input, velocity), motion, options, input.laser_motion},
        newest_from_base};
  }
}

bool SecondaryLasers::is_sample_due(int laser, const Pose2& newest_from_base) const {
  // Guesses. In CONSTANTS.md the ATE of a drive whose second laser is used is 4.1 mm; with half of
  // the way, or of kUsedLaserFactor, 2.4 and 1.4, with double 16 and 15: more samples are more
  // exact, and each takes a search.
  constexpr double kSampleDistance = 0.1;   // [m]
  constexpr double kSampleAngle = 0.05;     // [rad]
  constexpr double kUsedLaserFactor = 5.0;  // once it is used
  const SecondaryLaser& one = lasers_.at(laser);
  if (!one.newest_from_tried) {
    return true;
  }
  const Pose2 moved = one.newest_from_tried->inverse() * newest_from_base;
  const double part = one.is_used ? kUsedLaserFactor : 1.0;
  return moved.translation().norm() >= part * kSampleDistance ||
         std::abs(moved.theta) >= part * kSampleAngle;
}

void SecondaryLasers::sample(int laser_number, const PointScan& scan, const Pose2& map_from_base,
                             const Pose2& newest_from_base, const Eigen::Vector3d& velocity,
                             const PlacedScans& keys, const MapOptions& map_options,
                             const LikelihoodFieldOptions& field_options) {
  SecondaryLaser& laser = lasers_.at(laser_number);
  laser.newest_from_tried = newest_from_base;
  const bool is_found = laser.mount.is_found();
  const Pose2 expected = map_from_base * (is_found ? laser.mount.correction(velocity) : Pose2{});
  constexpr std::size_t kLeastPoints = 30;    // a guess: half and double were not tried
  constexpr std::size_t kNewestCompared = 3;  // more would tell how the map has drifted
  const SlamMap seen = rendered(newest_of(primary_.laser, keys, kNewestCompared), map_options,
                                field_options, MapUse::kShown);
  const PointScan part = seen_part(scan, expected, seen);
  if (part.points.size() < kLeastPoints) {
    return;
  }
  if (const std::optional<MatchResult> match = match_near(part, expected, is_found, seen.field)) {
    const Pose2 off = map_from_base.inverse() * match->map_from_base;
    laser.mount.add({{off.x, off.y, off.theta},
                     in_turned_frame(match->covariance, map_from_base.theta),
                     velocity});
    laser.is_used = laser.is_used ? !laser.mount.is_contradictory() : laser.mount.is_sure(velocity);
  }
}

std::map<int, SecondaryScan> SecondaryLasers::take_waiting(double stamp,
                                                           const Pose2& newest_from_base) {
  std::map<int, SecondaryScan> taken;
  for (auto& [number, laser] : lasers_) {
    if (laser.waiting && stamp - laser.waiting->measured.scan.stamp <= kMaxSilence) {
      taken[number] = {std::move(laser.waiting->measured),
                       newest_from_base.inverse() * laser.waiting->there_from_base};
    }
    laser.waiting.reset();
  }
  return taken;
}

void SecondaryLasers::move_on(const Pose2& before_from_newest) {
  for (auto& [number, laser] : lasers_) {
    if (laser.newest_from_tried) {
      laser.newest_from_tried = before_from_newest.inverse() * *laser.newest_from_tried;
    }
  }
}

void SecondaryLasers::shift_clock(double seconds) {
  primary_.silent_since += seconds;
  for (auto& [number, laser] : lasers_) {
    if (laser.waiting) {
      laser.waiting->measured.scan.stamp += seconds;
    }
  }
}

}  // namespace matchbox_slam
