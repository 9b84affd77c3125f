#pragma once

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "matchbox_slam/matching/pose_prior.hpp"
#include "matching/olson/correlative_search.hpp"

namespace matchbox_slam {

/// Whole numbers from `first` to `last`, both included.
struct StepRange {
  int first = 0;
  int last = 0;

  [[nodiscard]] int count() const { return last - first + 1; }
};

/// The penalty of SearchScoring, and its least over a box of poses. In a header, since the search
/// asks it of every pose.
class SearchPenalty {
 public:
  SearchPenalty(const SearchLattice& lattice, const SearchScoring& scoring, double resolution)
      : information_(scoring.prior_information),
        weight_(scoring.prior_weight),
        step_xy_(lattice.step_xy(resolution)),
        step_theta_(lattice.step_theta) {
    // Also where translations in some direction cost nothing.
    const Eigen::Matrix2d translation = information_.topLeftCorner<2, 2>();
    const Eigen::Vector2d coupling = information_.topRightCorner<2, 1>();
    follows_ = -translation.completeOrthogonalDecomposition().solve(coupling);
  }

  [[nodiscard]] std::int64_t at(const LatticePose& pose) const {
    return to_whole(
        penalty(square(step_xy_ * pose.x, step_xy_ * pose.y, step_theta_ * pose.theta)));
  }

  /// Not more than the penalty of any translation at this rotation.
  [[nodiscard]] std::int64_t least(int theta) const {
    const double turn = step_theta_ * theta;
    const Eigen::Vector2d optimum = turn * follows_;
    return below(square(optimum.x(), optimum.y(), turn));
  }

  /// Not more than the penalty of any pose with these translations at this rotation.
  [[nodiscard]] std::int64_t least(const StepRange& x, const StepRange& y, int theta) const {
    const double turn = step_theta_ * theta;
    const Eigen::Vector2d low(step_xy_ * x.first, step_xy_ * y.first);
    const Eigen::Vector2d high(step_xy_ * x.last, step_xy_ * y.last);
    const Eigen::Vector2d optimum = turn * follows_;
    if ((optimum.array() >= low.array()).all() && (optimum.array() <= high.array()).all()) {
      return below(square(optimum.x(), optimum.y(), turn));
    }
    double least = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 2; ++axis) {
      for (const double side : {low(axis), high(axis)}) {
        least = std::min(least, least_on_edge(axis, side, low(1 - axis), high(1 - axis), turn));
      }
    }
    return below(least);
  }

 private:
  /// Squared distance from the center, in standard deviations of the prior.
  [[nodiscard]] double square(double x, double y, double theta) const {
    const Eigen::Vector3d d(x, y, theta);
    return d.dot(information_ * d);
  }

  [[nodiscard]] double penalty(double square) const { return weight_ * prior_penalty(square); }

  /// Least square where the coordinate `axis` is `side` and the other one between two limits.
  [[nodiscard]] double least_on_edge(int axis, double side, double low, double high,
                                     double turn) const {
    const int other = 1 - axis;
    const double curvature = information_(other, other);
    const double slope = information_(other, axis) * side + information_(other, 2) * turn;
    const double best = curvature > 0.0 ? std::clamp(-slope / curvature, low, high) : low;
    const auto at = [&](double along) {
      return axis == 0 ? square(side, along, turn) : square(along, side, turn);
    };
    return std::min({at(best), at(low), at(high)});
  }

  [[nodiscard]] static std::int64_t to_whole(double value) {
    return value < static_cast<double>(kMaxPenalty) ? std::llround(std::max(0.0, value))
                                                    : kMaxPenalty;
  }

  /// The penalty of a squared distance; leaves room for rounding, here and in that of a pose.
  [[nodiscard]] std::int64_t below(double square) const {
    return std::max<std::int64_t>(0, to_whole(penalty(square) * (1.0 - 1e-9) - 1.0));
  }

  Eigen::Matrix3d information_;
  double weight_;
  double step_xy_;
  double step_theta_;
  Eigen::Vector2d follows_ = Eigen::Vector2d::Zero();  ///< best translation per rotation
};

}  // namespace matchbox_slam
