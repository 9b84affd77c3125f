#include "sensor/robot_beams.hpp"

#include <algorithm>
#include <cmath>

namespace matchbox_slam {
namespace {

// Guesses: half and double were not tried.
constexpr double kStep = 0.3;               // [m] between samples, or
constexpr double kTurn = 0.3;               // [rad]
constexpr double kReach = 1.5;              // [m] from the laser to the farthest part of a robot
constexpr double kWay = 1.0;                // [m] between two of the samples, at least
constexpr double kRangeTolerance = 0.05;    // [m] from the median: the noise of cheap lasers
constexpr double kMinReadShare = 0.7;       // of the samples
constexpr double kMinAgreeingShare = 0.95;  // of those
constexpr double kMargin = 1.5;             // beams to either side, which may end on the edge

}  // namespace

void RobotBeams::add(const LaserScan& scan, const Pose2& map_from_base,
                     const ProjectionOptions& options) {
  if (scan.ranges.size() != count_ || scan.angle_min != beams_.angle_min ||
      scan.angle_increment != beams_.angle_increment) {
    *this = {};
    count_ = scan.ranges.size();
    beams_ = scan;
    beams_.ranges.clear();
    samples_.assign(count_, {});
  }
  const Pose2 moved = newest_.inverse() * map_from_base;
  if (taken_ > 0 && moved.translation().norm() < kStep && std::abs(moved.theta) < kTurn) {
    return;
  }
  first_ = taken_ == 0 ? map_from_base : first_;
  newest_ = map_from_base;
  farthest_ = std::max(farthest_, (first_.inverse() * newest_).translation().norm());
  const double turned = (map_from_base.theta + kPi) / (2.0 * kPi);
  const auto direction = static_cast<std::size_t>(turned * static_cast<double>(kDirections));
  ++looked_.at(std::min(direction, kDirections - 1));
  take(scan, options);
  constexpr std::size_t kSearchInterval = 8;
  if (taken_ % kSearchInterval == 0 && has_looked_around()) {
    sectors_ = find();
  }
}

void RobotBeams::take(const LaserScan& scan, const ProjectionOptions& options) {
  const double least = std::max(scan.range_min, options.min_range);
  for (std::size_t k = 0; k < count_; ++k) {
    const float range = scan.ranges[k];
    const double angle = scan.angle_min + static_cast<double>(k) * scan.angle_increment;
    const bool is_near = static_cast<double>(range) >= least &&
                         static_cast<double>(range) < kReach &&
                         !is_masked(angle, options.masked_angles);
    const bool is_read = range > 0.0F;  // what is far, or meets nothing, is no part of the robot
    samples_[k].at(taken_ % kSamples) = is_near ? range : (is_read ? -1.0F : 0.0F);
  }
  ++taken_;
}

bool RobotBeams::has_looked_around() const {
  constexpr std::size_t kMinLooks = 2;
  return taken_ >= kMinSamples && farthest_ >= kWay &&
         std::all_of(looked_.begin(), looked_.end(),
                     [](std::size_t samples) { return samples >= kMinLooks; });
}

bool RobotBeams::is_on_robot(std::size_t beam) const {
  const std::array<float, kSamples>& all = samples_[beam];
  const std::size_t taken = std::min(taken_, kSamples);
  std::vector<float> near;
  std::size_t read = 0;
  for (std::size_t i = 0; i < taken; ++i) {
    read += all.at(i) != 0.0F ? 1 : 0;
    if (all.at(i) > 0.0F) {
      near.push_back(all.at(i));
    }
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return static_cast<double>(part) / static_cast<double>(whole);
  };
  if (near.empty() || share(read, taken) < kMinReadShare) {
    return false;
  }
  const auto middle = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
  std::nth_element(near.begin(), middle, near.end());
  const auto same = std::count_if(near.begin(), near.end(), [median = *middle](float range) {
    return std::abs(static_cast<double>(range - median)) <= kRangeTolerance;
  });
  return share(static_cast<std::size_t>(same), read) >= kMinAgreeingShare;
}

std::vector<double> RobotBeams::find() const {
  std::vector<double> found;
  const double margin = kMargin * std::abs(beams_.angle_increment);
  std::size_t last = 0;
  for (std::size_t k = 0; k < count_; ++k) {
    if (!is_on_robot(k)) {
      continue;
    }
    const double angle = beams_.angle_min + static_cast<double>(k) * beams_.angle_increment;
    if (!found.empty() && k <= last + 2) {
      found.back() = angle;
    } else {
      found.insert(found.end(), {angle, angle});
    }
    last = k;
  }
  for (std::size_t i = 0; i < found.size(); i += 2) {
    if (found[i] > found[i + 1]) {
      std::swap(found[i], found[i + 1]);  // swept clockwise
    }
    found[i] -= margin;
    found[i + 1] += margin;
  }
  return found;
}

}  // namespace matchbox_slam
