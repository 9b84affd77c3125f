#include "matchbox_slam/slam/doubt.hpp"

#include <algorithm>
#include <cmath>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/matching/contradiction.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matchbox_slam/matching/refinement.hpp"

namespace matchbox_slam {
namespace {

MatchResult with_contradiction(MatchResult result, const MatchProblem& problem) {
  result.contradiction = contradiction(problem.scan, result.map_from_base, problem.field);
  return result;
}

/// Share of a scan, by the length of wall that it stands for, that lies where nothing is mapped,
/// nor a wall is near: what is off by a little lies behind walls.
double unknown_share(const PointScan& scan, const Pose2& map_from_base,
                     const OccupancyGrid& occupancy, const LikelihoodField& field) {
  double unknown = 0.0;
  double all = 0.0;
  for (const ScanPoint& point : scan.points) {
    const Eigen::Vector2d place = map_from_base * point.position;
    if (place.allFinite() && point.weight > 0.0) {
      all += point.weight;
      const Cell cell = occupancy.geometry().cell_at(place);
      const bool is_new =
          !occupancy.is_known(cell) && field.distance(cell) >= LikelihoodField::kFar;
      unknown += is_new ? point.weight : 0.0;
    }
  }
  return all > 0.0 ? unknown / all : 1.0;
}

/// Odometry alone fits nothing, and is believed.
bool is_blind(const MatchResult& result) { return result.accepted() && result.score == 0.0; }

/// Scores of matchers do not compare: that of one is against key scans, say.
double score_on_map(const MatchProblem& problem, const Pose2& map_from_base) {
  RefinementOptions none;
  none.iterations = 0;
  const PosePrior prior{problem.predicted_map_from_base, problem.prior_covariance};
  return refine(problem.scan.points, problem.field, map_from_base, prior, none).score;
}

/// Where hardly anything is mapped nothing fits.
double fit_on_mapped_ground(double score, double unknown) {
  constexpr double kLeastMapped = 0.3;
  const double mapped = 1.0 - unknown;
  return mapped >= kLeastMapped ? std::min(1.0, score / mapped) : 0.0;
}

/// Too little of the scan fits, or clearly less than usual though all is mapped, or what does not
/// fit says that the pose is wrong.
bool is_worth_a_look(const MatchResult& result, const MatchProblem& problem,
                     const OccupancyGrid& occupancy, const Expectation& expected,
                     const DoubtOptions& options) {
  constexpr double kHardlyNew = 0.3;
  if (!result.accepted()) {
    return result.status == MatchStatus::kRejectedLowScore;
  }
  return result.contradiction > options.contradiction ||
         (result.score < options.score_drop * expected.usual_score &&
          unknown_share(problem.scan, result.map_from_base, occupancy, problem.field) < kHardlyNew);
}

MatchProblem with_wider_prior(const MatchProblem& problem, const DoubtOptions& options) {
  MatchProblem wide = problem;
  wide.prior_covariance += covariance_of(options.look_xy, options.look_theta);
  return wide;
}

bool is_near(const Pose2& a, const Pose2& b, double distance, double angle) {
  const Eigen::Vector3d apart = difference(a, b);
  return apart.head<2>().norm() <= distance && std::abs(apart.z()) <= angle;
}

bool is_same_place(const MatchResult& a, const MatchResult& b) {
  return is_near(a.map_from_base, b.map_from_base, 0.1, 0.05);
}

/// Whether a second look found the robot where the prediction does not have it.
bool is_jump(const MatchResult& found, const MatchProblem& problem) {
  return !is_near(found.map_from_base, problem.predicted_map_from_base, 0.2, 0.1);
}

/// A first look that the wide one does not better stays: what contradicts it has changed since it
/// was mapped, say, unless that is too much. What speaks for a pose is its score on the map, less
/// what contradicts it.
bool is_upheld(const MatchResult& first, double first_score, const MatchResult& second,
               const DoubtOptions& options) {
  constexpr double kBetter = 0.1;
  const double net = first_score - first.contradiction;
  const bool is_bettered = second.accepted() && !is_same_place(first, second) &&
                           second.score - second.contradiction > net + kBetter;
  return first.accepted() && !is_bettered && net >= options.least_net &&
         first.contradiction <= options.most_contradiction;
}

/// Whether what is seen lies where nothing was mapped yet, and nothing says that the prediction is
/// wrong: behind a corner, say, with few scans on the way.
bool is_new_ground(const MatchResult& result, const MatchProblem& problem,
                   const OccupancyGrid& occupancy, const DoubtOptions& options) {
  constexpr double kMostly = 0.5;
  return result.status == MatchStatus::kRejectedLowScore &&
         result.contradiction <= options.contradiction &&
         unknown_share(problem.scan, problem.predicted_map_from_base, occupancy, problem.field) >
             kMostly;
}

/// The prediction stands, and nobody knows how wrong it is.
MatchResult doubted(const MatchResult& result, const MatchProblem& wide) {
  MatchResult rejection =
      rejected(wide, result.accepted() ? MatchStatus::kRejectedContradiction : result.status);
  rejection.score = result.score;
  rejection.contradiction = result.contradiction;
  rejection.candidates = result.candidates;
  return rejection;
}

}  // namespace

const char* to_string(Certainty certainty) {
  switch (certainty) {
    case Certainty::kSure:
      return "sure";
    case Certainty::kSecondLook:
      return "second_look";
    case Certainty::kNewGround:
      return "new_ground";
    case Certainty::kDoubtful:
      return "doubtful";
  }
  return "unknown";
}

bool is_convincing(const MatchResult& match, const DoubtOptions& options) {
  return match.accepted() && match.score >= options.least_score &&
         match.contradiction <= options.contradiction && match.rival_share <= options.most_rival;
}

MatchResult search_exactly(const MatchProblem& problem) {
  OlsonOptions options;
  // The basin of the refinement is wider than these: [m], [rad], [m].
  options.step_xy = 0.05;
  options.step_theta = 0.02;
  options.point_spacing = 0.1;
  options.window_sigmas = 2.0;
  options.max_window_xy = 1.5;
  options.widenings = 0;
  return with_contradiction(OlsonMatcher(options).match(problem), problem);
}

WeighedMatch match_and_weigh(const ScanMatcher& matcher, const MatchProblem& problem,
                             const OccupancyGrid& occupancy, const Expectation& expected,
                             const DoubtOptions& options) {
  WeighedMatch first{with_contradiction(matcher.match(problem), problem)};
  const bool is_certain = problem.prior_covariance.isZero(0.0);
  if (!options.enabled || is_blind(first.match) || is_certain) {
    return first;
  }
  const bool is_to_look = is_worth_a_look(first.match, problem, occupancy, expected, options);
  if (!is_to_look && !expected.is_in_doubt) {
    return first;
  }
  const double score =
      first.match.accepted() ? score_on_map(problem, first.match.map_from_base) : 0.0;
  const auto fit_of = [&](const MatchResult& match, double score_there) {
    return fit_on_mapped_ground(
        score_there, unknown_share(problem.scan, match.map_from_base, occupancy, problem.field));
  };
  first.fit = fit_of(first.match, score);
  if (!is_to_look) {
    return first;
  }
  const MatchProblem wide = with_wider_prior(problem, options);
  WeighedMatch second{search_exactly(wide), Certainty::kSecondLook};
  if (is_upheld(first.match, score, second.match, options)) {
    return first;
  }
  if (is_convincing(second.match, options)) {
    second.fit = fit_of(second.match, second.match.score);
    second.jumped = is_jump(second.match, problem);
    return second;
  }
  if (is_new_ground(first.match, problem, occupancy, options)) {
    first.certainty = Certainty::kNewGround;
    return first;
  }
  return {doubted(first.match, wide), Certainty::kDoubtful};
}

}  // namespace matchbox_slam
