#pragma once

#include <Eigen/Core>
#include <cmath>

#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {

/// A rigid motion of the plane, SE(2). `a_from_b` takes coordinates in frame b to frame a, which is
/// also the pose of b in a: `a_from_c = a_from_b * b_from_c`, `point_a = a_from_b * point_b`.
struct Pose2 {
  double x = 0.0;      ///< [m]
  double y = 0.0;      ///< [m]
  double theta = 0.0;  ///< [rad], in [-pi, pi) in every pose that a function here returns

  [[nodiscard]] Eigen::Vector2d translation() const { return {x, y}; }

  [[nodiscard]] Pose2 inverse() const {
    const double c = std::cos(theta);
    const double s = std::sin(theta);
    return {-c * x - s * y, s * x - c * y, wrap_angle(-theta)};
  }

  [[nodiscard]] bool is_finite() const {
    return std::isfinite(x) && std::isfinite(y) && std::isfinite(theta);
  }
};

[[nodiscard]] inline Pose2 operator*(const Pose2& a_from_b, const Pose2& b_from_c) {
  const double c = std::cos(a_from_b.theta);
  const double s = std::sin(a_from_b.theta);
  return {a_from_b.x + c * b_from_c.x - s * b_from_c.y,
          a_from_b.y + s * b_from_c.x + c * b_from_c.y,
          wrap_angle(a_from_b.theta + b_from_c.theta)};
}

[[nodiscard]] inline Eigen::Vector2d operator*(const Pose2& a_from_b,
                                               const Eigen::Vector2d& point) {
  const double c = std::cos(a_from_b.theta);
  const double s = std::sin(a_from_b.theta);
  return {a_from_b.x + c * point.x() - s * point.y(), a_from_b.y + s * point.x() + c * point.y()};
}

[[nodiscard]] inline bool operator==(const Pose2& a, const Pose2& b) {
  return a.x == b.x && a.y == b.y && a.theta == b.theta;
}
[[nodiscard]] inline bool operator!=(const Pose2& a, const Pose2& b) { return !(a == b); }

/// By how much x [m], y [m] and theta [rad] of a pose differ from those of another one.
[[nodiscard]] inline Eigen::Vector3d difference(const Pose2& pose, const Pose2& from) {
  return {pose.x - from.x, pose.y - from.y, wrap_angle(pose.theta - from.theta)};
}

/// Whether two poses are nearer to each other than that: [m] and [rad]. (Places on a lattice lie as
/// far apart as its step is, which is not nearer.)
[[nodiscard]] inline bool are_near(const Pose2& a, const Pose2& b, double distance, double angle) {
  const Eigen::Vector3d apart = difference(a, b);
  return apart.head<2>().norm() < distance && std::abs(apart.z()) < angle;
}

/// The pose that differs by so much from another one: `difference(displaced(from, by), from) == by`
/// but for rounding and whole turns.
[[nodiscard]] inline Pose2 displaced(const Pose2& from, const Eigen::Vector3d& by) {
  return {from.x + by.x(), from.y + by.y(), wrap_angle(from.theta + by.z())};
}

/// The pose a `fraction` of the way from `a` to `b` at constant speed: the position on the straight
/// line, the heading along the shorter arc. Fractions outside [0, 1] extrapolate.
[[nodiscard]] inline Pose2 interpolate(const Pose2& a, const Pose2& b, double fraction) {
  return {a.x + fraction * (b.x - a.x), a.y + fraction * (b.y - a.y),
          wrap_angle(a.theta + fraction * wrap_angle(b.theta - a.theta))};
}

/// Covariance of `a_from_b * b_from_c`, each given over (x, y, theta) of its own parent frame and
/// independent of the other; first order.
[[nodiscard]] Eigen::Matrix3d compose_covariance(const Pose2& a_from_b,
                                                 const Eigen::Matrix3d& covariance_a_from_b,
                                                 const Pose2& b_from_c,
                                                 const Eigen::Matrix3d& covariance_b_from_c);

}  // namespace matchbox_slam
