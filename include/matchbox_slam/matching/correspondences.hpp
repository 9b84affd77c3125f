#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
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

struct PointRows;

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
  /// None, until there are some.
  Correspondences() = default;

  /// Points without a surface in reach take part with closeness 0. Cost: one look-up a point.
  /// @param points  in the order in which they were measured: neighbours may share a surface.
  /// @param fields  one or more; they must outlive this, and stay as they are.
  Correspondences(const std::vector<ScanPoint>& points, const PlacedFields& fields,
                  const Pose2& map_from_base)
      : Correspondences() {
    assign(points, fields, map_from_base);
  }
  Correspondences(const std::vector<ScanPoint>& points, const LikelihoodField& field,
                  const Pose2& map_from_base)
      : Correspondences() {
    assign(points, field, map_from_base);
  }

  /// Other points, or in other fields, as if made anew; in the memory that there is.
  void assign(const std::vector<ScanPoint>& points, const PlacedFields& fields,
              const Pose2& map_from_base) {
    assign(points, fields.data(), fields.size(), map_from_base);
  }
  void assign(const std::vector<ScanPoint>& points, const LikelihoodField& field,
              const Pose2& map_from_base) {
    const PlacedField in_map{&field, Pose2{}};
    assign(points, &in_map, 1, map_from_base);
  }

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

  /// The information about a motion, in the units of `linearise`, that map and scan confirm each
  /// other: by the product of what a surface's direction in the map says and what the point's own
  /// says. The errors of both are independent, so that in the mean they add nothing, while in the
  /// square of one they add up (instrumental variables; Wald 1940). It may be negative. Where one
  /// of them knows no direction, half of what the other says counts.
  /// @param motion  (x, y, theta) in the map frame.
  [[nodiscard]] double confirmed_information(double kernel, const Eigen::Vector3d& motion) const;

  /// Half the sum of squared residuals under the kernel after a small step as in `closeness` [m^2].
  [[nodiscard]] double cost(double kernel, const Eigen::Vector3d& step) const;

  /// The residuals under the kernel of the points as they were measured, before straighten_walls
  /// moved them (ScanPoint::moved): unlike all else here, which takes the points as they are.
  [[nodiscard]] ResidualSum residuals(double kernel) const;

  /// The cost of a step over that of none, and the same of its opposite. Of as many steps, in
  /// single precision: much faster than `cost`.
  /// @param costs  gets one element a step.
  void costs_of_both(double kernel, const std::vector<Eigen::Vector3d>& steps,
                     std::vector<std::array<double, 2>>& costs) const;

  /// Mean closeness, weighted by the points' lengths of wall, after a small step of the pose at
  /// which each point keeps its surface.
  /// @param step  (x [m], y [m], theta [rad]) in the map frame.
  [[nodiscard]] double closeness(double kernel, const Eigen::Vector3d& step) const;

 private:
  /// Numbers of the points, each kind a row of its own.
  enum Row : std::size_t {
    kX,  ///< base frame [m]
    kY,
    kMovedX,  ///< from where it was measured, base frame [m]
    kMovedY,
    kWall,     ///< length of wall that it stands for [m]
    kNormalC,  ///< of its own surface as kC, in the base frame; 0 without one
    kNormalS,
    kSpacing,   ///< how much blunter than a cell a surface without a direction is for it
    kPresent,   ///< 1 with a surface; without one, this and all that the surface tells is 0
    kSurfaceX,  ///< its middle, map frame [m]
    kSurfaceY,
    kSurfaceC,  ///< cosine and sine of the double angle of its normal, 0 without a direction
    kSurfaceS,
    kBlunt,   ///< variance of the distance to it, in units of the point's noise, ...
    kCommon,  ///< ... and of what all points next to it share
    kC,    ///< the matrix [1 + c, s; s, 1 - c] / 2 projects on the wall's normal; with c = s = 0 it
    kS,    ///< is half the identity, so that point to line and point to point are one formula
    kOwn,  ///< the former, and more where the scan shows another surface there
    kRotatedX,  ///< point minus the base's position, map axes [m]
    kRotatedY,
    kOffsetX,  ///< point minus the wall's middle [m]
    kOffsetY,
    kInformation,  ///< that the point adds, in units of a point's alone
    kRows
  };
  static constexpr std::size_t kSurfaceRows = kCommon + 1 - kPresent;
  using SurfaceNumbers = std::array<double, kSurfaceRows>;

  /// A field with its pose as numbers, and the cells of it that the points lie in.
  struct TurnedField {
    const LikelihoodField* field;
    Eigen::Vector2d origin;  ///< in the map
    double cosine, sine;     ///< of its heading there
    std::vector<std::int32_t> cell_x, cell_y;

    [[nodiscard]] Cell cell_of(std::size_t point) const { return {cell_x[point], cell_y[point]}; }
  };

  void assign(const std::vector<ScanPoint>& points, const PlacedField* fields, std::size_t count,
              const Pose2& map_from_base);
  [[nodiscard]] const double* row(Row which) const { return numbers_[which * blocks_].data(); }
  [[nodiscard]] double* row(Row which) { return numbers_[which * blocks_].data(); }
  [[nodiscard]] PointRows rows() const;
  [[nodiscard]] SurfaceNumbers nearest_surface(std::size_t point) const;
  [[nodiscard]] bool is_with_the_one_before(std::size_t point) const;
  [[nodiscard]] bool find_surfaces();
  [[nodiscard]] bool turn_normals(double heading);
  void find_own(std::size_t point);
  void weigh();

  struct alignas(64) Block : std::array<double, 16> {};

  std::vector<TurnedField> fields_;
  std::size_t count_ = 0;  ///< of points
  std::size_t blocks_ =
      0;  ///< of a row, of which the last is filled with points that count nothing
  std::vector<Block> numbers_;
  std::vector<std::int32_t> moved_;  ///< whether a point came into another cell
  std::vector<std::int32_t>
      table_;  ///< of surfaces by their places: the latest point at one, or none
  std::vector<std::int32_t> group_of_;  ///< of points at one surface, by point
  std::vector<double> points_in_;       ///< a group
  double total_weight_ = 0.0;
  double cosine_ = 1.0, sine_ = 0.0;  ///< of the pose's heading
  double coarse_heading_ = 0.0;       ///< by which the normals are turned [rad], in few steps
  Eigen::Vector2d double_turn_ = Eigen::Vector2d::UnitX();  ///< cosine and sine of its double
};

}  // namespace matchbox_slam
