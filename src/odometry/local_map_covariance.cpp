#include "odometry/local_map_covariance.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "matchbox_slam/motion/motion_prior.hpp"

namespace matchbox_slam {
namespace {

/// Takes the error of a pose to that of another one so far away in the same map.
Eigen::Matrix3d moved_by(const Eigen::Vector2d& step) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix(0, 2) = -step.y();
  matrix(1, 2) = step.x();
  return matrix;
}

/// How much each key scan counts in the map around the base; 1 in all.
std::vector<double> weights_at(const Eigen::Vector2d& base,
                               const std::vector<Eigen::Vector2d>& keys) {
  // The walls that say most are near, and were measured best by the key scans near there.
  // [m], by the errors of simulated drives. It decides covariances, and no pose: half or double
  // changes no byte of a trajectory (benchmark/reports/current/CONSTANTS.md).
  constexpr double kReach = 1.2;
  constexpr double kMinWeight = 1e-9;  // somebody has to count, however far away
  std::vector<double> weights;
  double sum = 0.0;
  for (const Eigen::Vector2d& key : keys) {
    const double away = (key - base).norm() / kReach;
    weights.push_back(std::max(std::exp(-0.5 * away * away), kMinWeight));
    sum += weights.back();
  }
  for (double& weight : weights) {
    weight /= sum;
  }
  return weights;
}

}  // namespace

LocalMapCovariance::LocalMapCovariance(const Pose2& fixed_from_base,
                                       const Eigen::Matrix3d& covariance)
    : keys_{fixed_from_base.translation()},
      joint_(covariance),
      base_(fixed_from_base.translation()),
      predicted_(Eigen::Matrix3d::Identity()),
      match_(Eigen::Matrix3d::Zero()) {}

void LocalMapCovariance::follow(const Pose2& fixed_from_base, const Eigen::Matrix3d& prior,
                                const Eigen::Matrix3d& match) {
  base_ = fixed_from_base.translation();
  const Eigen::Vector2d from_key = base_ - keys_.back();
  predicted_ = moved_by(-from_key) * left_by_match(prior, match) * moved_by(from_key) * predicted_;
  match_ = match;
}

Eigen::Matrix3Xd LocalMapCovariance::shares() const {
  const Eigen::Vector2d from_key = base_ - keys_.back();
  const Eigen::Matrix3d by_prediction = moved_by(from_key) * predicted_;
  const Eigen::Matrix3d by_map = moved_by(from_key) * (Eigen::Matrix3d::Identity() - predicted_);
  const std::vector<double> weights = weights_at(base_, keys_);
  Eigen::Matrix3Xd result(3, joint_.cols());
  Eigen::Index column = 0;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    result.middleCols<3>(column) = weights[i] * by_map * moved_by(keys_.back() - keys_[i]);
    column += 3;
  }
  result.rightCols<3>() += by_prediction;
  return result;
}

Eigen::Matrix3d LocalMapCovariance::covariance() const {
  const Eigen::Matrix3Xd from_keys = shares();
  return from_keys * joint_ * from_keys.transpose() + match_;
}

void LocalMapCovariance::add() {
  const Eigen::Matrix3Xd from_keys = shares();
  const Eigen::Index old = joint_.rows();
  const Eigen::Matrix3Xd across = from_keys * joint_;
  Eigen::MatrixXd joint(old + 3, old + 3);
  joint << joint_, across.transpose(), across, across * from_keys.transpose() + match_;
  joint_ = std::move(joint);
  keys_.push_back(base_);
  predicted_.setIdentity();
  match_.setZero();
}

void LocalMapCovariance::keep_newest(std::size_t count) {
  const std::size_t kept = std::clamp<std::size_t>(count, 1, keys_.size());
  keys_.erase(keys_.begin(), keys_.end() - static_cast<std::ptrdiff_t>(kept));
  const auto rows = static_cast<Eigen::Index>(3 * kept);
  joint_ = joint_.bottomRightCorner(rows, rows).eval();
}

}  // namespace matchbox_slam
