#include "matchbox_slam/lasers/extrinsic_calibration.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

using Jacobian = Eigen::Matrix<double, 3, 4>;

// Guesses, tried on a drive whose second laser tf has 36 mm and 1.2 degrees off
// (benchmark/reports/current/CONSTANTS.md), where its ATE is 4.1 mm.
// How far from tf a laser, and from its stamps a scan, may be: [m], [rad], [s]. 5 degrees, one scan
// of 20 Hz. Half or double changes the ATE by up to 4 %.
constexpr double kPriorXy = 0.1;
constexpr double kPriorTheta = 0.09;
constexpr double kPriorDelay = 0.05;
// What all matches against the same walls have in common: [m], [rad]. A tenth of a cell. With half
// the ATE is 2.2 mm, with double 6.1.
constexpr double kCommonXy = 0.005;
constexpr double kCommonTheta = 0.003;
constexpr double kKernel = 9.0;  // squared, of three degrees of freedom: 97 % are within
// A correction that is known so well does less harm than a match's own error: [m], [rad]. With half
// the laser is used later, and the ATE is 2.9 mm; double changes no byte, as kLeastAgreeing
// decides, with half of which it is 2.2 mm, and with double 3.9.
constexpr double kMaxSigmaXy = 0.004;
constexpr double kMaxSigmaTheta = 0.0025;
constexpr std::size_t kLeastAgreeing = 10;
constexpr double kLeastShare = 0.5;  // of samples that agree
// A guess; half or double changes no byte there.
constexpr std::size_t kMinSamplesToContradict = 50;

Jacobian jacobian(const Eigen::Vector3d& velocity) {
  Jacobian matrix;
  matrix << Eigen::Matrix3d::Identity(), velocity;
  return matrix;
}

Eigen::Matrix3d information_of(const ExtrinsicSample& sample) {
  const Eigen::Vector3d common(kCommonXy, kCommonXy, kCommonTheta);
  return (sample.covariance + Eigen::Matrix3d(common.cwiseAbs2().asDiagonal())).inverse();
}

/// Squared distance of a sample from what a mount would give, in standard deviations.
double distance(const ExtrinsicSample& sample, const Eigen::Matrix3d& information,
                const Eigen::Vector4d& value) {
  const Eigen::Vector3d off = sample.error - jacobian(sample.velocity) * value;
  return off.dot(information * off);
}

/// The best of the mounts that single samples tell, with delays that lasers have, or none.
Eigen::Vector4d best_start(const std::vector<ExtrinsicSample>& samples,
                           const std::vector<Eigen::Matrix3d>& information,
                           const Eigen::Matrix4d& prior) {
  const auto cost_of = [&](const Eigen::Vector4d& value) {
    double cost = value.dot(prior * value);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double off = distance(samples[i], information[i], value);
      cost += off / (1.0 + off / kKernel);
    }
    return cost;
  };
  constexpr std::size_t kTrialSamples = 40;  // a guess: half and double were not tried
  Eigen::Vector4d best = Eigen::Vector4d::Zero();
  double least = cost_of(best);
  for (std::size_t i = 0; i < samples.size(); i += samples.size() / kTrialSamples + 1) {
    for (const double delay : {-0.1, -0.05, 0.0, 0.05, 0.1}) {
      Eigen::Vector4d value;
      value << samples[i].error - delay * samples[i].velocity, delay;
      const double cost = cost_of(value);
      if (cost < least) {
        least = cost;
        best = value;
      }
    }
  }
  return best;
}

}  // namespace

ExtrinsicCalibration::ExtrinsicCalibration(std::vector<ExtrinsicSample> samples)
    : samples_(std::move(samples)) {
  solve();
}

void ExtrinsicCalibration::add(const ExtrinsicSample& sample) {
  if (samples_.size() == kMostSamples) {
    samples_.erase(samples_.begin());
  }
  samples_.push_back(sample);
  solve();
}

void ExtrinsicCalibration::solve() {
  const Eigen::Vector4d prior_sigma(kPriorXy, kPriorXy, kPriorTheta, kPriorDelay);
  const Eigen::Matrix4d prior = prior_sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  std::vector<Eigen::Matrix3d> information;
  for (const ExtrinsicSample& sample : samples_) {
    information.push_back(information_of(sample));
  }
  value_ = best_start(samples_, information, prior);
  constexpr int kIterations = 20;  // a guess: half and double were not tried
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix4d sum = prior;
    Eigen::Vector4d weighted = Eigen::Vector4d::Zero();
    double weights = 1e-9;
    double misfit = 0.0;
    agreeing_ = 0;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const double off = distance(samples_[i], information[i], value_);
      const double weight = 1.0 / ((1.0 + off / kKernel) * (1.0 + off / kKernel));
      const Jacobian by_value = jacobian(samples_[i].velocity);
      const Eigen::Matrix<double, 4, 3> gain = weight * by_value.transpose() * information[i];
      sum += gain * by_value;
      weighted += gain * samples_[i].error;
      weights += weight;
      misfit += weight * off / 3.0;
      agreeing_ += off < kKernel ? 1 : 0;
    }
    covariance_ = sum.inverse() * std::max(1.0, misfit / weights);
    value_ = sum.inverse() * weighted;
  }
}

Pose2 ExtrinsicCalibration::correction(const Eigen::Vector3d& velocity) const {
  const Eigen::Vector3d off = jacobian(velocity) * value_;
  return {off.x(), off.y(), wrap_angle(off.z())};
}

Eigen::Matrix3d ExtrinsicCalibration::correction_covariance(const Eigen::Vector3d& velocity) const {
  return jacobian(velocity) * covariance_ * jacobian(velocity).transpose();
}

bool ExtrinsicCalibration::is_found() const {
  return agreeing_ >= kLeastAgreeing &&
         static_cast<double>(agreeing_) >= kLeastShare * static_cast<double>(samples_.size());
}

bool ExtrinsicCalibration::is_sure(const Eigen::Vector3d& velocity) const {
  const Eigen::Vector3d variances = correction_covariance(velocity).diagonal();
  return is_found() && variances.head<2>().maxCoeff() <= kMaxSigmaXy * kMaxSigmaXy &&
         variances.z() <= kMaxSigmaTheta * kMaxSigmaTheta;
}

bool ExtrinsicCalibration::is_contradictory() const {
  return samples_.size() >= kMinSamplesToContradict &&
         static_cast<double>(agreeing_) < kLeastShare * static_cast<double>(samples_.size());
}

}  // namespace matchbox_slam
