#include "slam/common_ground.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "matchbox_slam/geometry/transform2.hpp"
#include "sensor/take_some.hpp"
#include "slam/prior_odds.hpp"
#include "slam/scan_evidence.hpp"

namespace matchbox_slam {
namespace {

/// Of the weight of a scan, that has to lie on known ground by the match alone.
constexpr double kMinDrawnShare = 0.02;

class Ground {
 public:
  explicit Ground(const SlamMap& map) : reflection_(map.reflection), field_(map.field) {}

  /// Whether anything is known about a cell from where poses and ranges, which are a little off,
  /// may have a point.
  [[nodiscard]] bool is_known(const Eigen::Vector2d& place) const {
    const Cell cell = reflection_.geometry().cell_at(place);
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        if (reflection_.counts({cell.x + x, cell.y + y}).is_known()) {
          return true;
        }
      }
    }
    return false;
  }

  /// Whether a hit lies on a wall that was seen from its other side alone. One without normal, as
  /// of few beams: on known ground that its beam comes to from unknown ground.
  [[nodiscard]] bool is_back(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                             const Eigen::Vector2d& normal) const {
    if (normal.isZero()) {
      constexpr double kMinWallThickness = 0.1;  // [m], less than most walls are thick
      return is_known(to) && !is_known(to - kMinWallThickness * (to - from).normalized());
    }
    return field_.shows_other_side(field_.geometry().cell_at(to), normal);
  }

 private:
  const ReflectionGrid& reflection_;
  const LikelihoodField& field_;
};

/// Of two poses that have a scan on ground known differently.
class Comparison {
 public:
  Comparison(const Pose2& match, const Pose2& other, const SlamMap& map)
      : match_(match), other_(other), ground_(map) {
    const Eigen::Vector2d between = match.translation() - other.translation();
    is_one_place_ = between.norm() < kOnePlace;
    way_ = between.norm() > 1e-6 ? between.normalized() : Eigen::Vector2d::Zero();
  }

  /// Whether the point lies on the other side of a wall, of which nothing is known, or on unknown
  /// ground by the other pose, on a wall along the way between both, which cannot tell them apart
  /// but by where it is known.
  [[nodiscard]] bool tells_nothing(const ScanPoint& point) const {
    return is_back(match_, point) ||
           (!ground_.is_known(other_ * point.position) && !is_facing(point));
  }

  /// Whether it is known by the match alone. What shows the other side of a wall by the other pose,
  /// too, draws to neither where both are one place; where they are not it does (COMMON_GROUND.md).
  [[nodiscard]] bool draws(const ScanPoint& point) const {
    return tells_nothing(point) && ground_.is_known(match_ * point.position) &&
           !(is_one_place_ && !point.normal.isZero() && is_back(other_, point));
  }

 private:
  static constexpr double kOnePlace = 0.002;  // [m]

  [[nodiscard]] bool is_back(const Transform2& map_from_base, const ScanPoint& point) const {
    return ground_.is_back(map_from_base * point.origin, map_from_base * point.position,
                           map_from_base.turned(point.normal));
  }
  [[nodiscard]] bool is_facing(const ScanPoint& point) const {
    constexpr double kMinFacingCosine = 0.5;
    return point.normal.isZero() ||
           std::abs(match_.turned(point.normal).dot(way_)) >= kMinFacingCosine;
  }

  Transform2 match_;
  Transform2 other_;
  bool is_one_place_;
  Eigen::Vector2d way_;
  Ground ground_;
};

/// Of the weight of a scan.
double share_drawn(const PointScan& scan, const Comparison& comparison) {
  double all = 0.0;
  double drawn = 0.0;
  take_some(scan, kEvidenceBeams, [&](const ScanPoint& point) {
    all += point.weight;
    drawn += comparison.draws(point) ? point.weight : 0.0;
  });
  return all > 0.0 ? drawn / all : 0.0;
}

void keep_what_tells(const PointScan& scan, const Comparison& comparison, PointScan& kept) {
  kept.stamp = scan.stamp;
  kept.points.clear();
  for (const ScanPoint& point : scan.points) {
    if (!comparison.tells_nothing(point)) {
      kept.points.push_back(point);
    }
  }
}

/// The match, moved to where odometry has it along the direction in which the scan holds it least,
/// and known no better there.
MatchResult let_go(const MatchResult& match, const MatchProblem& problem) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(match.covariance.topLeftCorner<2, 2>());
  const Eigen::Vector2d weakest = solver.eigenvectors().col(1);
  const Eigen::Vector2d off =
      problem.predicted_map_from_base.translation() - match.map_from_base.translation();
  const Eigen::Vector2d moved = weakest.dot(off) * weakest;
  MatchResult free = match;
  free.map_from_base = displaced(match.map_from_base, {moved.x(), moved.y(), 0.0});
  free.covariance.topLeftCorner<2, 2>() +=
      weakest.dot(problem.prior_covariance.topLeftCorner<2, 2>() * weakest) * weakest *
      weakest.transpose();
  return free;
}

}  // namespace

double evidence_between(const PointScan& scan, const Pose2& one, const Pose2& other,
                        const SlamMap& map) {
  const Comparison by_one(one, other, map);
  const Comparison by_other(other, one, map);
  PointScan common;
  common.stamp = scan.stamp;
  for (const ScanPoint& point : scan.points) {
    if (!by_one.tells_nothing(point) && !by_other.tells_nothing(point)) {
      common.points.push_back(point);
    }
  }
  return evidence_of(common, one, map).log_odds - evidence_of(common, other, map).log_odds;
}

MatchResult CommonGroundMatch::match(const ScanMatcher& matcher, const MatchProblem& problem,
                                     const SlamMap& map) {
  MatchResult first = matcher.match(problem);
  if (!first.accepted()) {
    return first;
  }
  const MatchResult free = let_go(first, problem);
  const Comparison comparison(first.map_from_base, free.map_from_base, map);
  if (share_drawn(problem.scan, comparison) < kMinDrawnShare) {
    return first;
  }
  keep_what_tells(problem.scan, comparison, common_);
  const MatchProblem common{common_,
                            problem.predicted_map_from_base,
                            problem.prior_covariance,
                            problem.field,
                            problem.recent_scans,
                            problem.seed,
                            problem.search_covariance};
  MatchResult second = matcher.match(common);
  if (!second.accepted()) {
    second = free;  // the rest tells nothing
  }
  if (are_near(second.map_from_base, first.map_from_base, 0.01, 0.005)) {
    return first;  // which all points have told
  }
  const double for_first =
      evidence_between(common_, first.map_from_base, second.map_from_base, map) +
      prior_log_odds(problem, first.map_from_base) - prior_log_odds(problem, second.map_from_base);
  return for_first > 0.0 ? first : second;
}

}  // namespace matchbox_slam
