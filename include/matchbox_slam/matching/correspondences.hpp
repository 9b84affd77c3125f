#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// A likelihood field, and where its frame lies in the map.
struct PlacedField {
  const LikelihoodField* field = nullptr;
  Pose2 map_from_field;
};

/// What points are matched to: one field, or several, of whose surfaces the nearest counts.
using PlacedFields = std::vector<PlacedField>;

/// The scan's part of the normal equations of least squares, for points with noise of unit
/// variance.
struct NormalEquations {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< over (x, y, theta) in the map frame
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// Weighted sums over the points, as they were measured: `squares / measurements` estimates the
/// variance of a point's noise [m^2].
struct ResidualSum {
  double squares = 0.0;       ///< of squared residuals [m^2]
  double measurements = 0.0;  ///< of the variances expected for a point's noise of 1 m^2
};

/// The points of a scan at one pose, each with the surface that is nearest to it. A point's
/// residual is its distance to the line along that surface, or to its mean position where it has no
/// direction.
///
/// The robust kernel is Geman and McClure's (1985): a residual r has the closeness k^2 / (k^2 +
/// r^2), 1 on the wall and 1/2 at the kernel's width k. It is shaped like a Gaussian, but made of
/// basic arithmetic, so that it is fast and yields the same bits everywhere.
///
/// A residual has two errors: its point's noise, which is its own, and its surface's error, which
/// it shares with all points next to that surface. In units of the noise's variance the surface's
/// is 1 / h + e, with h its hits and e what no number of hits averages out. So each of n points at
/// one surface has the information 1 / (1 + n (1 / h + e)): a lone far point counts nearly in full,
/// and a thousand points on a near wall no more than the wall is known.
class Correspondences {
 public:
  /// Points without a surface in reach take part with closeness 0. Cost: one look-up a point.
  /// @param points  in the order in which they were measured: neighbours may share a surface.
  /// @param fields  one or more; they must outlive this, and stay as they are.
  Correspondences(const std::vector<ScanPoint>& points, const PlacedFields& fields,
                  const Pose2& map_from_base);
  Correspondences(const std::vector<ScanPoint>& points, const LikelihoodField& field,
                  const Pose2& map_from_base)
      : Correspondences(points, PlacedFields{{&field, Pose2{}}}, map_from_base) {}

  /// The same points at another pose, as if made anew. Cost: look-ups for the points that get into
  /// another cell.
  void move_to(const Pose2& map_from_base);

  /// The sum of squared residuals under the kernel, linearised for Gauss-Newton.
  [[nodiscard]] NormalEquations linearise(double kernel) const;

  /// The information about a motion, in the units of `linearise`, that comes from surfaces which
  /// clearly face its direction, as the end of a corridor does: not from many that are turned a
  /// little by noise, nor from those without a direction.
  /// @param motion  (x, y, theta) in the map frame, of which (x, y) is a unit vector.
  [[nodiscard]] double facing_information(double kernel, const Eigen::Vector3d& motion) const;

  /// Half the sum of squared residuals under the kernel after a small step as in `closeness` [m^2].
  [[nodiscard]] double cost(double kernel, const Eigen::Vector3d& step) const;

  /// The residuals under the kernel of the points as they were measured, before straighten_walls
  /// moved them (ScanPoint::moved): unlike all else here, which takes the points as they are.
  [[nodiscard]] ResidualSum residuals(double kernel) const;

  /// Mean closeness, weighted by the points' lengths of wall, after a small step of the pose at
  /// which each point keeps its surface.
  /// @param step  (x [m], y [m], theta [rad]) in the map frame.
  [[nodiscard]] double closeness(double kernel, const Eigen::Vector3d& step) const;

 private:
  /// A point of the scan, and what lies next to it.
  struct Point {
    Eigen::Vector2d position;  ///< [m], base frame
    Eigen::Vector2d moved;     ///< from where it was measured [m]
    double weight = 0.0;       ///< length of wall [m]
    /// Number of the field that was looked up last; none yet.
    std::size_t field = std::numeric_limits<std::size_t>::max();
    Cell cell;  ///< in that field
    bool has_surface = false;
    Surface surface;      ///< in the map frame
    double own = 0.0;     ///< variance of the distance to it, in units of the point's noise, ...
    double common = 0.0;  ///< ... and of what all points next to it share
  };

  /// A field with its pose as numbers.
  struct TurnedField {
    explicit TurnedField(const PlacedField& placed);
    [[nodiscard]] Cell cell_at(const Eigen::Vector2d& map_position) const;
    [[nodiscard]] Surface to_map(const Surface& surface) const;

    const LikelihoodField* field;
    Eigen::Vector2d origin;  ///< in the map
    double cosine, sine;     ///< of its heading there
  };

  bool look_up(const Eigen::Vector2d& position, Point& point) const;
  bool take_surface(std::size_t field, const Cell& cell, Point& point) const;
  void weigh();

  /// Padded with points that count nothing to a whole number of lanes.
  struct Arrays {
    std::vector<double> rotated_x, rotated_y;  ///< point minus the base's position, map axes [m]
    std::vector<double> offset_x, offset_y;    ///< point minus the wall's middle [m]
    /// The matrix [1 + c, s; s, 1 - c] / 2 projects on the wall's normal; with c = s = 0 it is half
    /// the identity, so that point to line and point to point are one formula.
    std::vector<double> c, s;
    std::vector<double> weight;       ///< length of wall [m]
    std::vector<double> variance;     ///< of the residual, in units of a point's noise
    std::vector<double> information;  ///< that the point adds, in units of a point's alone
  };

  std::vector<TurnedField> fields_;
  std::vector<Point> points_;
  Arrays arrays_;
  double total_weight_ = 0.0;
  double cosine_ = 1.0, sine_ = 0.0;  ///< of the pose's heading
};

}  // namespace matchbox_slam
