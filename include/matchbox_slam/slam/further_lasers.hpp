#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "matchbox_slam/slam/mount_estimate.hpp"

namespace matchbox_slam {

/// A scan that waits for the next one of the leading laser.
struct FurtherScan {
  MeasuredScan measured;  ///< as the laser is mounted by the estimate
  Pose2 there_from_base;  ///< in the base at the leading laser's newest scan, or at this one
};

/// What is known of a laser beside the first.
struct FurtherLaser {
  MountEstimate mount;
  bool is_used = false;   ///< since the mount was sure, until samples contradict it
  Pose2 base_from_laser;  ///< by tf, at the newest scan
  std::optional<Pose2> newest_from_tried;  ///< base at the newest sample that was tried
  std::optional<FurtherScan> waiting;
};

/// Lasers beside the first, number 0. That one leads: its scans are matched and tell where the base
/// is. Where another one is on the base is estimated from how it fits the leading one's newest key
/// scans; older ones would tell how the map has drifted. Once that is known, its newest scan is
/// matched together with the leading laser's next one, as if both were one. (One by one, each would
/// follow the walls that it saw itself, and the pose would jump from scan to scan.) While the first
/// is silent another one leads. A value.
class FurtherLasers {
 public:
  /// All but the lasers themselves.
  struct Lead {
    int laser = 0;
    int others = 0;             ///< scans in a row that the leading laser was silent for
    double silent_since = 0.0;  ///< [s], of these
  };

  FurtherLasers() = default;
  FurtherLasers(std::map<int, FurtherLaser> lasers, const Lead& lead)
      : lasers_(std::move(lasers)), lead_(lead) {}

  [[nodiscard]] const std::map<int, FurtherLaser>& all() const { return lasers_; }
  [[nodiscard]] const Lead& lead() const { return lead_; }

  /// Whether a scan is the leading laser's, or becomes so as that one is silent.
  /// @param newest  stamp [s] of the leading laser's newest scan.
  bool leads(const ScanInput& input, const std::optional<double>& newest);

  /// Where tf has the laser; that of a further one put right, where that is known.
  [[nodiscard]] Eigen::Isometry3d base_from_laser(const ScanInput& input,
                                                  const Eigen::Vector3d& velocity) const;

  /// Takes a scan of another laser than the leading one.
  /// @param newest_from_base  of the base at this scan, in the base at the leading one's newest.
  /// @param motion            during the scan.
  void wait(const ScanInput& input, const Eigen::Vector3d& velocity, const Pose2& newest_from_base,
            const Pose2& motion, const ProjectionOptions& options);

  /// Whether the base has moved enough since the laser's last sample for another one.
  [[nodiscard]] bool is_sample_due(int laser, const Pose2& newest_from_base) const;

  /// Learns from a scan, in the frame of the base, where the laser is.
  /// @param map_from_base  by the leading laser.
  void sample(int laser, const PointScan& scan, const Pose2& map_from_base,
              const Pose2& newest_from_base, const Eigen::Vector3d& velocity,
              const PlacedScans& keys, const MapOptions& map_options,
              const LikelihoodFieldOptions& field_options);

  /// What waited for a scan of the leading laser, by laser, each in the base at this scan.
  /// @param newest_from_base  of the base at this scan, in the base at the one before.
  std::map<int, FurtherScan> take_waiting(double stamp, const Pose2& newest_from_base);

  /// The base has moved so from the leading laser's newest scan but one to the newest.
  void move_on(const Pose2& before_from_newest);

 private:
  std::map<int, FurtherLaser> lasers_;
  Lead lead_;
};

}  // namespace matchbox_slam
