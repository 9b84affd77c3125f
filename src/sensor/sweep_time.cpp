#include "sensor/sweep_time.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

constexpr double kLinearisationTime = 0.1;  // s: between no sweep and those of the slowest lasers
constexpr double kPriorDeviation = 0.5;     // s, of sweep times
constexpr double kLargestDeviation = 0.05;  // s, of what one scan tells

constexpr double kMinTurnRate = 0.1;     // rad/s; below, scans are hardly bent
constexpr double kOtherTurnRate = 0.07;  // rad/s, by which that of the reference has to differ
constexpr double kOtherSpeed = 0.05;     // m/s, likewise of all that moves a hit
constexpr double kArm = 3.0;             // m, at which turning moves one
constexpr std::size_t kMaxStraightScans = 40;  // scans of a robot that does not turn
// m, to the reference: farther off other things are seen. With 0.5 nothing is told of one scan a
// metre; with 4 much the same (benchmark/reports/current/RECORDINGS.md).
constexpr double kMaxDistance = 2.0;
constexpr double kMaxAge = 10.0;  // s
constexpr std::size_t kMaxRecentScans = 40;

constexpr int kIterations = 6;
constexpr int kWideIterations = 2;  // of them, while odometry's error is still in the pose
constexpr double kWideGate = 0.3;   // m
constexpr double kGate = 0.15;      // m
constexpr std::size_t kFewestPairs = 20;
constexpr double kLeastNoise = 0.01;  // m

constexpr std::ptrdiff_t kNeighbours = 2;  // neighbours to either side that tell a normal
constexpr double kMaxLineDistance = 0.06;  // m: neighbours farther off the line form none
constexpr double kSparseSpacing = 8.0;     // beams' distances that neighbours may lie apart

/// The normal of the line through neighbours of hit `k`; zero where they form none.
template <typename Hit>
Eigen::Vector2d normal_at(const std::vector<Hit>& hits, std::size_t k, double spacing) {
  const auto count = static_cast<std::ptrdiff_t>(hits.size());
  const auto neighbour = [&](std::ptrdiff_t by) -> const Eigen::Vector2d& {
    const std::ptrdiff_t index = (static_cast<std::ptrdiff_t>(k) + by + count) % count;
    return hits[static_cast<std::size_t>(index)].position;
  };
  const Eigen::Vector2d& first = neighbour(-kNeighbours);
  const Eigen::Vector2d along = neighbour(kNeighbours) - first;
  const double length = along.norm();
  const double sparse = 4.0 * kSparseSpacing * spacing * hits[k].position.norm();
  if (count < 2 * kNeighbours + 1 || length < 1e-6 || length > std::max(0.1, sparse)) {
    return Eigen::Vector2d::Zero();
  }
  const Eigen::Vector2d normal = Eigen::Vector2d(-along.y(), along.x()) / length;
  double off = 0.0;
  for (std::ptrdiff_t by = 1 - kNeighbours; by < kNeighbours; ++by) {
    off += std::abs((neighbour(by) - first).dot(normal));
  }
  return off < kMaxLineDistance ? normal : Eigen::Vector2d(Eigen::Vector2d::Zero());
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

/// Unknown are the pose in the reference and the sweep time, counted from kLinearisationTime.
struct SweepTimeEstimator::Fit {
  struct Pair {
    double distance;      ///< [m] off the line, at kLinearisationTime
    Eigen::Vector4d row;  ///< of the distance by x, y, theta and sweep time
  };

  Pose2 reference_from_base;
  double sweep = 0.0;
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();

  [[nodiscard]] std::vector<Pair> pairs(const Hits& scan, const Hits& reference, double gate) const;
  bool improve(const std::vector<Pair>& pairs);
};

std::vector<SweepTimeEstimator::Fit::Pair> SweepTimeEstimator::Fit::pairs(const Hits& scan,
                                                                          const Hits& reference,
                                                                          double gate) const {
  std::vector<Pair> pairs;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(reference_from_base.theta).toRotationMatrix();
  const auto count = static_cast<std::ptrdiff_t>(reference.hits.size());
  for (const Hit& hit : scan.hits) {
    const Eigen::Vector2d turned = turn * hit.position;
    const Eigen::Vector2d position = turned + reference_from_base.translation();
    const Eigen::Vector2d slope = turn * hit.slope;
    const auto after = std::lower_bound(
        reference.hits.begin(), reference.hits.end(), std::atan2(position.y(), position.x()),
        [](const Hit& other, double bearing) { return other.bearing < bearing; });
    const Hit* nearest = nullptr;
    double least = gate + 2.0 * reference.spacing * position.norm();
    for (std::ptrdiff_t by = -2; by < 2; ++by) {
      const std::ptrdiff_t index = (after - reference.hits.begin() + by + count) % count;
      const Hit& other = reference.hits[static_cast<std::size_t>(index)];
      const double away = (position + sweep * slope - other.position - sweep * other.slope).norm();
      if (away < least) {
        least = away;
        nearest = &other;
      }
    }
    if (nearest != nullptr && !nearest->normal.isZero()) {
      const Eigen::Vector2d& normal = nearest->normal;
      pairs.push_back({(position - nearest->position).dot(normal),
                       {normal.x(), normal.y(), turned.x() * normal.y() - turned.y() * normal.x(),
                        (slope - nearest->slope).dot(normal)}});
    }
  }
  return pairs;
}

/// One step of iteratively reweighted least squares with Huber's weights. False: they do not tell.
bool SweepTimeEstimator::Fit::improve(const std::vector<Pair>& pairs) {
  if (pairs.size() < kFewestPairs) {
    return false;
  }
  std::vector<double> distances;
  distances.reserve(pairs.size());
  for (const Pair& pair : pairs) {
    distances.push_back(std::abs(pair.distance + sweep * pair.row(3)));
  }
  const double noise = std::max(kLeastNoise, 1.4826 * median_of(distances));
  information = Eigen::Matrix4d::Zero();
  information(3, 3) = 1.0 / (kPriorDeviation * kPriorDeviation);
  Eigen::Vector4d gradient(0.0, 0.0, 0.0, sweep * information(3, 3));
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const double weight = 1.0 / (noise * noise * std::max(1.0, distances[k] / (1.5 * noise)));
    const Eigen::Vector4d& row = pairs[k].row;
    information += weight * row * row.transpose();
    gradient += weight * (pairs[k].distance + sweep * row(3)) * row;
  }
  const Eigen::LDLT<Eigen::Matrix4d> solver(information);
  const Eigen::Vector4d step = solver.solve(gradient);
  if (solver.info() != Eigen::Success || !step.allFinite()) {
    return false;
  }
  reference_from_base = displaced(reference_from_base, -step.head<3>());
  sweep -= step(3);
  return true;
}

SweepTimeEstimator::Hits SweepTimeEstimator::hits_of(const MovingScan& moving) {
  const LaserScan& scan = moving.scan;
  Hits result;
  result.odom_from_base = moving.odom_from_base;
  result.stamp = scan.stamp;
  result.velocity = moving.velocity;
  result.turn_rate = moving.turn_rate;
  result.spacing = std::abs(scan.angle_increment);
  const double last = std::max(1.0, static_cast<double>(scan.ranges.size()) - 1.0);
  for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
    const auto range = static_cast<double>(scan.ranges[k]);
    if (!(range > std::max(scan.range_min, 0.01) && range < scan.range_max)) {
      continue;
    }
    const double angle = scan.angle_min + static_cast<double>(k) * scan.angle_increment;
    const Eigen::Vector3d in_laser(range * std::cos(angle), range * std::sin(angle), 0.0);
    const Eigen::Vector2d in_base = (moving.base_from_laser * in_laser).head<2>();
    const double share = static_cast<double>(k) / last;
    const double time = share * kLinearisationTime;
    Hit hit;
    hit.position = Eigen::Rotation2Dd(moving.turn_rate * time) * in_base + time * moving.velocity;
    hit.slope = share * (moving.turn_rate * Eigen::Vector2d(-hit.position.y(), hit.position.x()) +
                         moving.velocity);
    hit.bearing = std::atan2(hit.position.y(), hit.position.x());
    result.hits.push_back(hit);
  }
  for (std::size_t k = 0; k < result.hits.size(); ++k) {
    result.hits[k].normal = normal_at(result.hits, k, result.spacing);
  }
  std::sort(result.hits.begin(), result.hits.end(),
            [](const Hit& a, const Hit& b) { return a.bearing < b.bearing; });
  return result;
}

/// Of the scans near by the one whose speed differs most.
const SweepTimeEstimator::Hits* SweepTimeEstimator::reference_for(const Hits& scan) const {
  const Hits* reference = nullptr;
  double most = kOtherSpeed;
  for (const Hits& other : recent_) {
    const double differs =
        kArm * std::abs(other.turn_rate - scan.turn_rate) + (other.velocity - scan.velocity).norm();
    const double away =
        (other.odom_from_base.translation() - scan.odom_from_base.translation()).norm();
    if (away < kMaxDistance && scan.stamp - other.stamp < kMaxAge && differs > most) {
      most = differs;
      reference = &other;
    }
  }
  return reference;
}

/// None: the scan does not tell.
std::optional<ToldSweepTime> SweepTimeEstimator::fit(const Hits& scan, const Hits& reference) {
  Fit fit;
  fit.reference_from_base = reference.odom_from_base.inverse() * scan.odom_from_base;
  for (int k = 0; k < kIterations; ++k) {
    if (!fit.improve(fit.pairs(scan, reference, k < kWideIterations ? kWideGate : kGate))) {
      return std::nullopt;
    }
  }
  const double variance = fit.information.inverse()(3, 3);
  if (!(variance > 0.0 && variance < kLargestDeviation * kLargestDeviation)) {
    return std::nullopt;
  }
  const bool is_turning = std::abs(scan.turn_rate) > kMinTurnRate &&
                          std::abs(scan.turn_rate - reference.turn_rate) > kOtherTurnRate;
  return ToldSweepTime{kLinearisationTime + fit.sweep, std::sqrt(variance), is_turning};
}

std::optional<ToldSweepTime> SweepTimeEstimator::add(const MovingScan& scan) {
  Hits hits = hits_of(scan);
  if (hits.hits.size() < kFewestPairs) {
    return std::nullopt;
  }
  std::optional<ToldSweepTime> told;
  if (std::abs(hits.turn_rate) > kMinTurnRate || straight_ < kMaxStraightScans) {
    if (const Hits* reference = reference_for(hits)) {
      told = fit(hits, *reference);
    }
  }
  if (told && !told->is_turning && straight_ >= kMaxStraightScans) {
    told.reset();
  }
  if (told) {
    ++(told->is_turning ? turning_ : straight_);
  }
  recent_.push_back(std::move(hits));
  if (recent_.size() > kMaxRecentScans) {
    recent_.pop_front();
  }
  return told;
}

}  // namespace matchbox_slam
