#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/lasers/extrinsic_calibration.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"

namespace matchbox_slam {

/// A scan that waits for the next one of the primary laser.
struct SecondaryScan {
  MeasuredScan measured;  ///< as the laser is mounted by the estimate
  Pose2 there_from_base;  ///< in the base at the primary laser's newest scan, or at this one
};

/// What is known of a laser beside the first.
struct SecondaryLaser {
  ExtrinsicCalibration mount;
  bool is_used = false;   ///< since the mount was sure, until samples contradict it
  Pose2 base_from_laser;  ///< by tf, at the newest scan
  std::optional<Pose2> newest_from_tried;  ///< base at the newest sample that was tried
  std::optional<SecondaryScan> waiting;
};

/// Lasers beside the first, number 0. That one leads: its scans are matched and tell where the base
/// is. Where another one is on the base is estimated from how it fits the primary one's newest key
/// scans; older ones would tell how the map has drifted. Once that is known, its newest scan is
/// matched together with the primary laser's next one, as if both were one. (One by one, each would
/// follow the walls that it saw itself, and the pose would jump from scan to scan.) While the first
/// is silent another one leads. A value.
class SecondaryLasers {
 public:
  /// All but the lasers themselves.
  struct Primary {
    int laser = 0;
    int others = 0;             ///< scans in a row that the primary laser was silent for
    double silent_since = 0.0;  ///< [s], of these
  };

  SecondaryLasers() = default;
  SecondaryLasers(std::map<int, SecondaryLaser> lasers, const Primary& primary)
      : lasers_(std::move(lasers)), primary_(primary) {}

  [[nodiscard]] const std::map<int, SecondaryLaser>& all() const { return lasers_; }
  [[nodiscard]] const Primary& primary() const { return primary_; }

  /// Whether a scan is the primary laser's, or becomes so as that one is silent.
  /// @param newest  stamp [s] of the primary laser's newest scan.
  bool select_primary(const ScanInput& input, const std::optional<double>& newest);

  /// Where tf has the laser; that of a secondary one put right, where that is known.
  [[nodiscard]] Eigen::Isometry3d base_from_laser(const ScanInput& input,
                                                  const Eigen::Vector3d& velocity) const;

  /// Takes a scan of another laser than the primary one.
  /// @param newest_from_base  of the base at this scan, in the base at the primary one's newest.
  /// @param motion            during the scan.
  void wait(const ScanInput& input, const Eigen::Vector3d& velocity, const Pose2& newest_from_base,
            const Pose2& motion, const ProjectionOptions& options);

  /// Whether the base has moved enough since the laser's last sample for another one.
  [[nodiscard]] bool is_sample_due(int laser, const Pose2& newest_from_base) const;

  /// Learns from a scan, in the frame of the base, where the laser is.
  /// @param map_from_base  by the primary laser.
  void sample(int laser, const PointScan& scan, const Pose2& map_from_base,
              const Pose2& newest_from_base, const Eigen::Vector3d& velocity,
              const PlacedScans& keys, const MapOptions& map_options,
              const LikelihoodFieldOptions& field_options);

  /// What waited for a scan of the primary laser, by laser, each in the base at this scan.
  /// @param newest_from_base  of the base at this scan, in the base at the one before.
  std::map<int, SecondaryScan> take_waiting(double stamp, const Pose2& newest_from_base);

  /// The base has moved so from the primary laser's newest scan but one to the newest.
  void move_on(const Pose2& before_from_newest);

  /// See EngineState.
  void shift_clock(double seconds);

 private:
  std::map<int, SecondaryLaser> lasers_;
  Primary primary_;
};

}  // namespace matchbox_slam
