#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <tuple>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/laser_scan.hpp"

namespace matchbox_slam {

/// What a planar laser reaches [m]: long-range ones end at 80 m. A point beyond is a wild reading,
/// and nothing may take memory or time up to there.
constexpr double kFarthestPoint = 100.0;

/// A beam that hit something.
struct ScanPoint {
  Eigen::Vector2d position;                          ///< [m], where the beam ended
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< [m], where the beam left the laser
  /// Unit normal of the surface at the hit, towards the laser; zero where the neighbouring points
  /// form no line.
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();
  /// Length of wall that the point stands for [m], capped: equal weights would let a near wall with
  /// a thousand returns outvote everything far away.
  double weight = 0.0;
  bool joined_to_next = false;  ///< one straight wall reaches from this point to the next one
  /// How far `straighten_walls` moved the point along its beam, away from the laser [m].
  double moved = 0.0;
  /// How far the nearest of the neighbouring beams passes from the point [m].
  double spacing = 0.0;
};

/// How much of the surface between a point and its neighbours is known: with a normal all of it,
/// without one what the beam hit. Where beams are degrees apart, the next scan finds such a surface
/// anywhere between, and hits that are taken for all of it hold the robot where they were seen.
[[nodiscard]] inline double known_share(const ScanPoint& point) {
  constexpr double kHit = 0.05;  // [m], a cell by default; half and double were not tried
  return point.normal.isZero() && point.spacing > kHit ? kHit / point.spacing : 1.0;
}

/// A beam that met nothing on its way to `end`.
struct FreeRay {
  Eigen::Vector2d origin;  ///< [m]
  Eigen::Vector2d end;     ///< [m]
};

/// One scan as points in the frame of the robot's base at the scan's stamp, in the order in which
/// they were measured, with the robot's motion during the scan taken out.
struct PointScan {
  double stamp = 0.0;  ///< [s]
  std::vector<ScanPoint> points;
  std::vector<FreeRay> free_rays;
};

/// Which readings count, and for what.
struct ProjectionOptions {
  double min_range = 0.0;
  double max_range = 80.0;
  double free_range = 5.0;
  double max_point_weight = 0.1;
  double surface_radius = 0.15;
  double max_wall_gap = 2.0;
  double max_drop = 0.15;
  double max_rise = 1.0;
  double max_tilt = 0.15;
  std::vector<double> masked_angles;
  bool straighten_walls = true;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.min_range, "min_range", between(0.0, 1000.0), "m",
           "Shorter readings are ignored, such as the robot's own body; the scan's range_min holds "
           "too.");
    option(self.max_range, "max_range", between(0.1, 1000.0), "m",
           "Longer readings are treated as no return; the scan's range_max holds too.");
    option(self.free_range, "free_range", between(0.0, 1000.0), "m",
           "A beam without return clears the map up to here; 0 lets it clear nothing.");
    option(self.max_point_weight, "max_point_weight", between(1e-3, 1e3), "m",
           "Cap of the length of wall that one point stands for when a scan is matched.");
    option(self.surface_radius, "surface_radius", between(1e-3, 10.0), "m",
           "A point's surface normal comes from its neighbours within this distance.");
    option(self.max_wall_gap, "max_wall_gap", between(0.0, 100.0), "m",
           "Neighbouring hits on one straight line are joined to a wall up to this distance.");
    option(self.max_drop, "max_drop", between(1e-3, 1000.0), "m",
           "A beam of a tilted laser counts up to where it is this much lower than the laser: what "
           "it meets below may be the floor.");
    option(
        self.max_rise, "max_rise", between(1e-3, 1000.0), "m",
        "A beam of a tilted laser counts up to where it is this much higher than the laser: what "
        "it meets above may be the ceiling.");
    option(self.max_tilt, "max_tilt", between(0.0, kPi / 2.0), "rad",
           "Scans whose plane is tilted by more than this are skipped.");
    option(self.masked_angles, "masked_angles", between(-2.0 * kPi, 2.0 * kPi), "rad",
           "Sectors in which readings are ignored, such as behind the robot's own mast: [from, to, "
           "from, to, ...], each counter-clockwise and less than a turn, by the angles of every "
           "laser.");
    option(
        self.straighten_walls, "straighten_walls", any(), "",
        "Moves hits that agree with a straight wall, but for the noise of their ranges, onto it.");
  }
};

[[nodiscard]] inline bool operator==(const ProjectionOptions& a, const ProjectionOptions& b) {
  const auto all = [](const ProjectionOptions& of) {
    return std::tie(of.min_range, of.max_range, of.free_range, of.max_point_weight,
                    of.surface_radius, of.max_wall_gap, of.max_drop, of.max_rise, of.max_tilt,
                    of.masked_angles, of.straighten_walls);
  };
  return all(a) == all(b);
}

/// Throws ConfigurationError when the options do not fit together.
void check_projection_options(const ProjectionOptions& options);

/// Whether an angle lies in one of the sectors, as of ProjectionOptions::masked_angles.
[[nodiscard]] bool is_masked(double angle, const std::vector<double>& sectors);

/// Turns measured ranges into points, by REP-117: NaN, -inf, 0 and anything below the minimum range
/// is ignored, and so are masked angles; +inf and anything from the maximum range on is a ray
/// without return; the rest hits. Readings of less than 0.2 m are ignored, too, where most beams
/// read so: of what covers the laser. Where `straighten_walls` is on, hits that agree with a
/// straight wall are moved onto it along their beams, whose range noise is estimated from the scan.
/// Beams are projected to the horizontal plane; one that leaves the band of heights from `max_drop`
/// below the laser to `max_rise` above it is cut there, and is a ray without return then.
/// `max_tilt` is left to whoever has the scan.
/// @param base_from_laser  pose of the laser in the upright base, at the first beam, in full 3-D:
///                tilted, upside down, anywhere.
/// @param motion  pose of the base at the last beam in the base at the first; beams in between are
///                placed by interpolation. Identity for a robot at rest or an instantaneous scan.
/// @param laser_motion  of the laser besides, as of ScanInput; interpolated as well.
/// Cost: beams times the neighbours within the surface radius.
[[nodiscard]] PointScan project_scan(
    const LaserScan& scan, const Eigen::Isometry3d& base_from_laser, const Pose2& motion,
    const ProjectionOptions& options,
    const Eigen::Isometry3d& laser_motion = Eigen::Isometry3d::Identity());

/// Does as project_scan, in memory that it keeps from scan to scan, and with the directions of a
/// laser's beams, which hardly ever change.
class ScanProjector {
 public:
  ScanProjector();
  ScanProjector(ScanProjector&& other) noexcept;
  ScanProjector& operator=(ScanProjector&& other) noexcept;
  ~ScanProjector();

  /// @param result  gets the points; its memory is used again.
  void project(const LaserScan& scan, const Eigen::Isometry3d& base_from_laser, const Pose2& motion,
               const ProjectionOptions& options, const Eigen::Isometry3d& laser_motion,
               PointScan& result);

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

/// Angle between the plane of a laser, upside down or not, and the horizontal [rad]: 0 to pi / 2.
[[nodiscard]] double tilt_of(const Eigen::Isometry3d& base_from_laser);

/// A scan as it was measured, and what it takes to make the same points of it again.
struct MeasuredScan {
  LaserScan scan;
  Eigen::Isometry3d base_from_laser = Eigen::Isometry3d::Identity();
  Pose2 motion;  ///< of the base from the first beam to the last
  ProjectionOptions options;
  Eigen::Isometry3d laser_motion = Eigen::Isometry3d::Identity();  ///< as of ScanInput
  bool is_of_image = false;  ///< nobody measured it: a laser would see it in an image of a map
};

[[nodiscard]] inline PointScan project_scan(const MeasuredScan& measured) {
  return project_scan(measured.scan, measured.base_from_laser, measured.motion, measured.options,
                      measured.laser_motion);
}

/// Adds the points and rays of another scan.
/// @param base_from_other  of that one's frame in the frame of `scan`.
void append(const PointScan& other, const Pose2& base_from_other, PointScan& scan);

}  // namespace matchbox_slam
