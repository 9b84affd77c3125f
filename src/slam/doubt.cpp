#include "matchbox_slam/slam/doubt.hpp"

#include <algorithm>
#include <cmath>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/matching/contradiction.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matchbox_slam/matching/refinement.hpp"

namespace matchbox_slam {
namespace {

/// Of the second look, whose steps are wider than the matcher's: the refinement's basin is wider
/// still.
OlsonOptions look_options() {
  OlsonOptions options;
  options.step_xy = 0.05;       // [m]
  options.step_theta = 0.02;    // [rad]
  options.point_spacing = 0.1;  // [m]
  // What scores less is refined to something convincing by chance alone; with this limit a search
  // where nothing fits takes a third of the time.
  options.search_floor = 0.15;
  options.most_look_ups = 2500000;  // some 10 ms
  options.window_sigmas = 2.0;
  options.max_window_xy = 1.5;  // [m]
  options.widenings = 0;
  return options;
}

/// Share of a scan, by the length of wall that it stands for, of the points that lie in such cells.
template <typename IsSuch>
double share_in(const PointScan& scan, const Pose2& map_from_base, const OccupancyGrid& occupancy,
                IsSuch&& is_such) {
  double such = 0.0;
  double all = 0.0;
  for (const ScanPoint& point : scan.points) {
    const Eigen::Vector2d place = map_from_base * point.position;
    if (place.allFinite() && point.weight > 0.0) {
      all += point.weight;
      such += is_such(occupancy.geometry().cell_at(place)) ? point.weight : 0.0;
    }
  }
  return all > 0.0 ? such / all : 1.0;
}

/// Share of a scan that lies where nothing is mapped, nor a wall is near: what is off by a little
/// lies behind walls.
double unknown_share(const PointScan& scan, const Pose2& map_from_base,
                     const OccupancyGrid& occupancy, const LikelihoodField& field) {
  return share_in(scan, map_from_base, occupancy, [&](const Cell& cell) {
    return !occupancy.is_known(cell) && field.distance(cell) >= LikelihoodField::kFar;
  });
}

/// Share of a scan that lies where nothing is mapped, close behind walls, too.
double unmapped_share(const PointScan& scan, const Pose2& map_from_base,
                      const OccupancyGrid& occupancy) {
  return share_in(scan, map_from_base, occupancy,
                  [&](const Cell& cell) { return !occupancy.is_known(cell); });
}

/// Odometry alone fits nothing, and is believed.
bool is_blind(const MatchResult& result) { return result.accepted() && result.score == 0.0; }

/// Scores of matchers do not compare: one may be that against a key scan.
double score_on_map(const MatchProblem& problem, const Pose2& map_from_base) {
  RefinementOptions none;
  none.iterations = 0;
  const PosePrior prior{problem.predicted_map_from_base, problem.prior_covariance};
  return refine(problem.scan.points, problem.field, map_from_base, prior, none).score;
}

/// Where hardly anything is mapped nothing fits.
double fit_on_mapped_ground(double score, double unknown) {
  // A guess: half or double changes no byte of six drives with faults and two logs
  // (benchmark/reports/current/CONSTANTS.md).
  constexpr double kLeastMapped = 0.3;
  const double mapped = 1.0 - unknown;
  return mapped >= kLeastMapped ? std::min(1.0, score / mapped) : 0.0;
}

/// Share of a scan on unmapped ground. A guess; with half of it aces is 21 % worse, double changes
/// no byte (CONSTANTS.md).
constexpr double kHardlyNew = 0.3;

/// Too little of the scan fits, or clearly less than usual though all is mapped, or what does not
/// fit says that the pose is wrong.
bool is_worth_a_look(const MatchResult& result, const MatchProblem& problem,
                     const OccupancyGrid& occupancy, const Expectation& expected,
                     const DoubtOptions& options) {
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

/// Two cells, and 0.1 m two metres away. Guesses, as those of a jump: half and double were not
/// tried.
bool is_same_place(const Pose2& a, const Pose2& b) { return is_near(a, b, 0.1, 0.05); }

/// Where the prediction has it, a first look that was refuted is no rival.
bool is_convincing_here(MatchResult match, const MatchResult& first, const MatchProblem& problem,
                        const DoubtOptions& options) {
  if (first.accepted() && is_same_place(match.map_from_base, problem.predicted_map_from_base)) {
    match.rival_share = 0.0;
  }
  return is_convincing(match, options);
}

/// In the window of a wide prior. Where corridors cross they are alike after a quarter of a turn,
/// and on the search's lattice, whose poses are up to half a step off, a wrong one may score more
/// than the true one: what a narrower window holds is taken unless something farther is clearly
/// better.
MatchResult look_wide(const MatchProblem& problem, const MatchProblem& wide,
                      const OccupancyGrid& occupancy, const DoubtOptions& options) {
  constexpr double kTheta = 0.2;    // [rad], its window twice that, well below a quarter of a turn
  constexpr double kClearly = 0.1;  // as of a first look that stays
  MatchProblem narrow = problem;
  narrow.prior_covariance += covariance_of(options.look_xy, std::min(kTheta, options.look_theta));
  const MatchResult near = search_exactly(narrow, occupancy);
  const MatchResult far = search_exactly(wide, occupancy);
  const bool is_bettered = far.accepted() && net_score(far) > net_score(near) + kClearly;
  return near.accepted() && !is_bettered ? near : far;
}

/// In the window of a wide prior; and in that of the prior without the points that lay on backs of
/// walls, which draw the rest of a scan there.
MatchResult look_again(const MatchResult& first, const MatchProblem& problem,
                       const MatchProblem& wide, const OccupancyGrid& occupancy,
                       const DoubtOptions& options) {
  const MatchResult far = look_wide(problem, wide, occupancy, options);
  const PointScan fronts =
      without_backs(problem.scan, first.map_from_base, occupancy, problem.field);
  if (fronts.points.size() == problem.scan.points.size()) {
    return far;
  }
  MatchResult other =
      search_exactly({fronts, problem.predicted_map_from_base, problem.prior_covariance,
                      problem.field, problem.recent_scans, problem.seed});
  if (!other.accepted()) {
    return far;
  }
  other.score = score_on_map(problem, other.map_from_base);
  other = with_contradiction(other, problem, occupancy);
  return !far.accepted() || net_score(other) > net_score(far) ? other : far;
}

/// Whether a second look turned the robot far from where a first one that nothing contradicts has
/// it. Such a turn that odometry missed would have beams go through walls; where none does, what
/// fits little is new, and where corridors cross they are alike after a quarter of a turn.
bool is_far_fetched(const MatchResult& first, const MatchResult& second,
                    const MatchProblem& problem) {
  constexpr double kHardly =
      0.01;  // share of a scan; half or double changes no byte (CONSTANTS.md)
  return first.contradiction <= kHardly &&
         is_turned_far(second.map_from_base, problem.predicted_map_from_base);
}

/// A first look that the second one does not better, clearly where the prediction does not speak
/// for it, stays: what contradicts it has changed since it was mapped, say, unless that is too
/// much. What speaks for a pose is its score on the map, less what contradicts it.
bool is_upheld(const MatchResult& first, double first_score, const MatchResult& second,
               const MatchProblem& problem, const DoubtOptions& options) {
  constexpr double kClearly = 0.1;  // a guess; half or double changes no byte (CONSTANTS.md)
  const double net = first_score - first.contradiction;
  const double better =
      is_same_place(second.map_from_base, problem.predicted_map_from_base) ? 0.0 : kClearly;
  const bool is_bettered =
      second.accepted() && !is_same_place(first.map_from_base, second.map_from_base) &&
      net_score(second) > net + better && !is_far_fetched(first, second, problem);
  // Walls may be so thin that both sides are one.
  const double through = contradiction(problem.scan, first.map_from_base, problem.field);
  return first.accepted() && !is_bettered && net >= options.least_net &&
         through <= options.most_contradiction;
}

/// Whether what is seen lies where nothing was mapped yet, and nothing says that the prediction is
/// wrong: behind a corner, say, with few scans on the way. Where what fits is the back of walls,
/// what lies close behind walls counts, too.
bool is_new_ground(const MatchResult& first, const MatchProblem& problem,
                   const OccupancyGrid& occupancy, const DoubtOptions& options) {
  constexpr double kMostly = 0.5;  // more than not; half or double changes no byte (CONSTANTS.md)
  if (first.accepted()) {
    if (net_score(first) >= options.least_net) {
      return false;
    }
    const MatchResult there =
        with_contradiction(rejected(problem, MatchStatus::kRejectedLowScore), problem, occupancy);
    return there.contradiction <= options.contradiction &&
           unmapped_share(problem.scan, problem.predicted_map_from_base, occupancy) > kMostly;
  }
  return first.status == MatchStatus::kRejectedLowScore &&
         first.contradiction <= options.contradiction &&
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

bool is_jump(const Pose2& found, const Pose2& predicted) {
  return !is_near(found, predicted, 0.2, 0.1);
}

bool is_turned_far(const Pose2& found, const Pose2& predicted) {
  constexpr double kFar = 0.5;  // [rad], a guess; half or double changes no byte (CONSTANTS.md)
  return std::abs(difference(found, predicted).z()) > kFar;
}

MatchResult with_contradiction(MatchResult result, const MatchProblem& problem,
                               const OccupancyGrid& occupancy) {
  const PointScan& scan = problem.scan;
  const Pose2& pose = result.map_from_base;
  const double on_backs = share_on_backs(scan, pose, occupancy, problem.field);
  result.contradiction = std::min(1.0, contradiction(scan, pose, problem.field) + 2.0 * on_backs);
  return result;
}

double net_score(const MatchResult& match) { return match.score - match.contradiction; }

bool is_convincing(const MatchResult& match, const DoubtOptions& options) {
  const bool is_searched = !match.proof || match.proof->gap() == 0.0;
  return match.accepted() && is_searched && match.score >= options.least_score &&
         match.contradiction <= options.contradiction && match.rival_share <= options.most_rival;
}

bool is_out_of_place(const PointScan& scan, const Pose2& map_from_base, const SlamMap& map,
                     const DoubtOptions& options) {
  if (contradiction(scan, map_from_base, map.field) > options.contradiction) {
    return true;
  }
  const PlacedScans none;
  const MatchProblem here{scan, map_from_base, Eigen::Matrix3d::Identity(), map.field, none, 0};
  return score_on_map(here, map_from_base) < options.least_score &&
         unknown_share(scan, map_from_base, map.occupancy, map.field) < kHardlyNew;
}

MatchResult search_exactly(const MatchProblem& problem) {
  return OlsonMatcher(look_options()).match(problem);
}

MatchResult search_exactly(const MatchProblem& problem, const OccupancyGrid& occupancy) {
  return with_contradiction(search_exactly(problem), problem, occupancy);
}

WeighedMatch match_and_weigh(const ScanMatcher& matcher, const MatchProblem& problem,
                             const OccupancyGrid& occupancy, const Expectation& expected,
                             const DoubtOptions& options) {
  WeighedMatch first{with_contradiction(matcher.match(problem), problem, occupancy)};
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
  WeighedMatch second{look_again(first.match, problem, wide, occupancy, options),
                      Certainty::kSecondLook};
  if (is_upheld(first.match, score, second.match, problem, options)) {
    first.upheld = true;
    return first;
  }
  if (is_convincing_here(second.match, first.match, problem, options)) {
    second.fit = fit_of(second.match, second.match.score);
    second.jumped = is_jump(second.match.map_from_base, problem.predicted_map_from_base);
    return second;
  }
  if (is_new_ground(first.match, problem, occupancy, options)) {
    return {
        with_contradiction(rejected(problem, MatchStatus::kRejectedLowScore), problem, occupancy),
        Certainty::kNewGround};
  }
  return {doubted(first.match, wide), Certainty::kDoubtful};
}

std::optional<WeighedMatch> match_if_convincing(const MatchProblem& problem,
                                                const OccupancyGrid& occupancy,
                                                const Expectation& expected,
                                                const DoubtOptions& options) {
  WeighedMatch found{search_exactly(problem, occupancy)};
  found.fit = fit_on_mapped_ground(
      found.match.score,
      unknown_share(problem.scan, found.match.map_from_base, occupancy, problem.field));
  const bool is_usual = found.fit >= options.score_drop * expected.usual_score;
  return is_convincing(found.match, options) && is_usual ? std::optional(found) : std::nullopt;
}

}  // namespace matchbox_slam
