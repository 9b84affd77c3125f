#include "matchbox_slam/motion/odometry_calibration.hpp"

#include <algorithm>
#include <cmath>

#include "matchbox_slam/motion/motion_prior.hpp"

namespace matchbox_slam {
namespace {

constexpr double kLength = 1.0;   // [m] of a stretch; all four are guesses that change little
constexpr double kMemory = 20.0;  // [m] of way, for the noise
constexpr double kDeviations = 3.0;
const Eigen::Vector3d kDrift(2e-4, 4e-4, 1e-4);  // in a metre: wheels wear, and floors differ

constexpr double kMaxPriorLeft = 0.5;  // of the prior, in all directions together
constexpr double kLeastNoise = 1e-8;   // [m^2/m], [rad^2/m]

/// @param innovation  and `row`, by which errors make it, over the square root of the length.
void update(double innovation, const Eigen::Vector3d& row, double weight, double& noise,
            OdometryCalibration& result) {
  const Eigen::Vector3d reached = result.covariance * row;
  const double variance = row.dot(reached) + noise;
  const double most = kDeviations * std::sqrt(variance);
  const double taken = std::clamp(innovation, -most, most);
  const Eigen::Vector3d gain = reached / variance;
  result.missing += gain * taken;
  result.covariance -= gain * reached.transpose();
  noise = std::max(noise + weight * (taken * taken - noise), kLeastNoise);
}

void add_stretch(const OdometryCalibration::Stretch& stretch, const Pose2& fixed_from_base,
                 OdometryCalibration& result) {
  const double root = std::sqrt(stretch.length);
  const double weight = 1.0 - std::exp(-stretch.length / kMemory);
  const OdometryCalibration first;
  for (int i = 0; i < 3; ++i) {
    double& variance = result.covariance(i, i);
    variance = std::min(variance + kDrift[i] * kDrift[i] * stretch.length, first.covariance(i, i));
  }
  const Pose2& told = stretch.first_from_newest;
  const Eigen::Vector3d off =
      difference(stretch.fixed_from_first.inverse() * fixed_from_base, told);
  update(off.z() / root, Eigen::Vector3d(0.0, stretch.turn, stretch.forward) / root, weight,
         result.noise[1], result);
  if (const double chord = told.translation().norm(); chord > 0.0) {
    update(off.head<2>().dot(told.translation()) / chord / root,
           Eigen::Vector3d(chord, 0.0, 0.0) / root, weight, result.noise[0], result);
  }
}

}  // namespace

Pose2 calibrated(const OdometryCalibration& calibration, const Pose2& moved) {
  const Eigen::Vector3d& missing = calibration.missing;
  const double turn = missing[1] * moved.theta + missing[2] * moved.x;
  const Pose2 bent = Pose2{0.0, 0.0, 0.5 * turn} * moved;
  return {(1.0 + missing[0]) * bent.x, (1.0 + missing[0]) * bent.y, wrap_angle(moved.theta + turn)};
}

OdometryCalibration calibrate(OdometryCalibration calibration, const CalibrationStep& step) {
  std::optional<OdometryCalibration::Stretch>& stretch = calibration.stretch;
  if (left_by_match(step.prior, step.posterior).trace() > kMaxPriorLeft) {
    stretch.reset();
    return calibration;
  }
  if (stretch && stretch->stamp == step.stamp_before) {
    stretch->stamp = step.stamp;
    stretch->first_from_newest = stretch->first_from_newest * calibrated(calibration, step.moved);
    stretch->forward += step.moved.x;
    stretch->turn += step.moved.theta;
    stretch->length += way_with_turn(step.moved);
    if (stretch->length < kLength) {
      return calibration;
    }
    add_stretch(*stretch, step.fixed_from_base, calibration);
  }
  stretch = OdometryCalibration::Stretch{step.stamp, step.fixed_from_base, {}, 0.0, 0.0, 0.0};
  return calibration;
}

}  // namespace matchbox_slam
