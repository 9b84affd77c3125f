#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

/// How one match of a secondary laser disagrees with where the first one has the base.
struct ExtrinsicSample {
  Eigen::Vector3d error;       ///< (x [m], y [m], theta [rad]) of the base by this laser, as it is
                               ///< said to be mounted, in the base by the first
  Eigen::Matrix3d covariance;  ///< of the match, over the error
  Eigen::Vector3d velocity;    ///< of the base in its own frame: (x [m/s], y [m/s], theta [rad/s])
};

/// Where a secondary laser really is on the base, and how much later than its stamps say its scans
/// are taken, from how its matches disagree with the first laser's. A delay looks like a mount that
/// is off by velocity times delay; at many velocities both are told apart.
///
/// Least squares over the newest samples with the kernel of Geman and McClure (1985), started at
/// the best of them, so that wrong matches count little even where they are the most. A value.
class ExtrinsicCalibration {
 public:
  static constexpr std::size_t kMostSamples = 200;

  ExtrinsicCalibration() : ExtrinsicCalibration(std::vector<ExtrinsicSample>{}) {}
  /// Of samples, oldest first; the same ones yield the same bits.
  explicit ExtrinsicCalibration(std::vector<ExtrinsicSample> samples);

  void add(const ExtrinsicSample& sample);
  [[nodiscard]] const std::vector<ExtrinsicSample>& samples() const { return samples_; }

  /// (x [m], y [m], theta [rad]) by which the laser is off where tf has it, seen from the base, and
  /// the delay [s]: a scan of stamp t was taken at t plus this.
  [[nodiscard]] const Eigen::Vector4d& value() const { return value_; }
  [[nodiscard]] const Eigen::Matrix4d& covariance() const { return covariance_; }

  /// base_from_laser is this times that of tf, for scans that are taken to be of their stamps.
  [[nodiscard]] Pose2 correction(const Eigen::Vector3d& velocity) const;
  [[nodiscard]] Eigen::Matrix3d correction_covariance(const Eigen::Vector3d& velocity) const;

  /// Samples that agree with the estimate, within three standard deviations.
  [[nodiscard]] std::size_t agreeing() const { return agreeing_; }
  /// Whether most samples agree.
  [[nodiscard]] bool is_found() const;
  /// Whether the correction is known well enough for the laser's scans to be used.
  [[nodiscard]] bool is_sure(const Eigen::Vector3d& velocity) const;
  /// Whether many samples agree on no mount: the lasers see different things, or move.
  [[nodiscard]] bool is_contradictory() const;

 private:
  void solve();

  std::vector<ExtrinsicSample> samples_;
  Eigen::Vector4d value_;
  Eigen::Matrix4d covariance_;
  std::size_t agreeing_ = 0;
};

}  // namespace matchbox_slam
