#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

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
  SearchPenalty(const SearchLattice& lattice, const SearchScoring& scoring, double resolution);

  [[nodiscard]] std::int64_t at(const LatticePose& pose) const {
    return to_whole(
        penalty(square(step_xy_ * pose.x, step_xy_ * pose.y, step_theta_ * pose.theta)));
  }

  /// Not more than the penalty of any translation at these rotations.
  [[nodiscard]] std::int64_t least(const StepRange& theta) const {
    const double turn = step_theta_ * std::clamp(0, theta.first, theta.last);
    const Eigen::Vector2d optimum = turn * follows_;
    return below(square(optimum.x(), optimum.y(), turn));
  }

  /// Not more than the penalty of any pose with these translations at these rotations.
  [[nodiscard]] std::int64_t least(const StepRange& x, const StepRange& y,
                                   const StepRange& theta) const {
    // First where the rotation is closest to the center, which mostly settles it.
    const bool is_rising = theta.first >= 0;
    Least first = least_at(x, y, is_rising ? theta.first : theta.last);
    if (theta.count() == 1 || (is_rising ? first.slope >= 0.0 : first.slope <= 0.0)) {
      return below(first.square);
    }
    Least last = least_at(x, y, is_rising ? theta.last : theta.first);
    if (!is_rising) {
      std::swap(first, last);
    }
    if (first.slope >= 0.0) {
      return below(first.square);
    }
    if (last.slope <= 0.0) {
      return below(last.square);
    }
    // Over the rotations the least square is convex: nowhere below its tangents.
    const double between = step_theta_ * (theta.count() - 1);
    const double crossing =
        (last.slope * between - (last.square - first.square)) / (last.slope - first.slope);
    return below(std::max(0.0, first.square + first.slope * std::clamp(crossing, 0.0, between)));
  }

 private:
  /// Least square over some translations, and its change with the rotation.
  struct Least {
    double square;
    double slope;
  };

  [[nodiscard]] Least least_at(const StepRange& x, const StepRange& y, int theta) const {
    const double turn = step_theta_ * theta;
    const Eigen::Vector2d low(step_xy_ * x.first, step_xy_ * y.first);
    const Eigen::Vector2d high(step_xy_ * x.last, step_xy_ * y.last);
    const Eigen::Vector2d optimum = turn * follows_;
    const Eigen::Vector2d nearest = optimum.cwiseMax(low).cwiseMin(high);
    if (nearest == optimum) {
      return least_square(optimum, turn);
    }
    // On an edge that faces the optimum, since on the way there the square only falls.
    Least least{std::numeric_limits<double>::infinity(), 0.0};
    for (int axis = 0; axis < 2; ++axis) {
      if (nearest(axis) != optimum(axis)) {
        const Least edge = least_on_edge(axis, nearest(axis), low(1 - axis), high(1 - axis), turn);
        least = edge.square < least.square ? edge : least;
      }
    }
    return least;
  }

  [[nodiscard]] Least least_square(const Eigen::Vector2d& at, double turn) const {
    const Eigen::Vector3d d(at.x(), at.y(), turn);
    return {d.dot(information_ * d), 2.0 * information_.row(2).dot(d)};
  }

  /// Squared distance from the center, in standard deviations of the prior.
  [[nodiscard]] double square(double x, double y, double theta) const {
    const Eigen::Vector3d d(x, y, theta);
    return d.dot(information_ * d);
  }

  [[nodiscard]] double penalty(double square) const { return weight_ * prior_penalty(square); }

  /// Where the coordinate `axis` is `side` and the other one between two limits.
  [[nodiscard]] Least least_on_edge(int axis, double side, double low, double high,
                                    double turn) const {
    const int other = 1 - axis;
    const double curvature = information_(other, other);
    const double slope = information_(other, axis) * side + information_(other, 2) * turn;
    Eigen::Vector2d at;
    at(axis) = side;
    at(other) = curvature > 0.0 ? std::clamp(-slope / curvature, low, high) : low;
    return least_square(at, turn);
  }

  /// As std::llround, which is a call.
  [[nodiscard]] static std::int64_t to_whole(double value) {
    if (!(value < static_cast<double>(kMaxPenalty))) {
      return kMaxPenalty;
    }
    const double positive = std::max(0.0, value);
    const auto whole = static_cast<std::int64_t>(positive);
    return whole + static_cast<std::int64_t>(positive - static_cast<double>(whole) >= 0.5);
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
