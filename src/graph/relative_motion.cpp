#include "graph/relative_motion.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "graph/map_drift.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"

namespace matchbox_slam {
namespace {

Eigen::Matrix3d propagated(const Eigen::Matrix3d& covariance, const Eigen::Matrix3d& by) {
  return symmetric(by * covariance * by.transpose());
}

/// With as little drift as can be.
Eigen::Matrix3d least_covariance(const RelativeMotion& motion) {
  return motion.covariance - (1.0 - kLeastDriftShare) * motion.drift;
}

Eigen::Matrix3d fused(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return symmetric(a - a * (a + b).inverse() * a);
}

}  // namespace

RelativeMotion motion_of(const PoseEdge& edge) {
  return {edge.from_to, edge.covariance, edge.drift.asDiagonal()};
}

RelativeMotion reversed(const RelativeMotion& motion) {
  const Pose2 back = motion.pose.inverse();
  Eigen::Matrix3d by;
  by.topLeftCorner<2, 2>() = -Eigen::Rotation2Dd(back.theta).toRotationMatrix();
  by.row(2).setZero();
  by.col(2) = Eigen::Vector3d(back.y, -back.x, -1.0);
  return {back, propagated(motion.covariance, by), propagated(motion.drift, by)};
}

RelativeMotion composed(const RelativeMotion& first, const RelativeMotion& second, double weight) {
  const auto sum = [&](const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
    return symmetric(compose_covariance(first.pose, weight * a, second.pose, b));
  };
  return {first.pose * second.pose, sum(first.covariance, second.covariance),
          sum(first.drift, second.drift)};
}

RelativeMotion fused(const RelativeMotion& a, const RelativeMotion& b) {
  const Eigen::Matrix3d covariance = fused(a.covariance, b.covariance);
  const Eigen::Vector3d apart = difference(b.pose, a.pose);
  const Eigen::Matrix3d gain = a.covariance * (a.covariance + b.covariance).inverse();
  const Eigen::Matrix3d least = fused(least_covariance(a), least_covariance(b));
  return {displaced(a.pose, gain * apart), covariance, covariance - least};
}

Eigen::Vector3d drift_apart(const Eigen::Matrix3d& drift) {
  constexpr double kRounding = 1e-6;  // of it is left out, so that rounding adds none
  const Eigen::Vector3d sigmas = drift.diagonal().cwiseMax(0.0).cwiseSqrt();
  if (!(sigmas.array() > 0.0).all()) {
    return Eigen::Vector3d::Zero();
  }
  const Eigen::Matrix3d correlation = drift.cwiseQuotient(sigmas * sigmas.transpose());
  const double least =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(correlation, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .minCoeff();
  return std::max(0.0, least - kRounding) * drift.diagonal();
}

}  // namespace matchbox_slam
