#include "slam/likeliest_match.hpp"

#include <algorithm>
#include <cstddef>

#include "matchbox_slam/slam/near_map.hpp"

namespace matchbox_slam {
namespace {

/// Whether the robot would have been carried there. What a doubtful match tells against all that
/// odometry says has to be confirmed: three of 109 robots that were carried off at 3 to 8 m/s drew
/// a scan 0.3 to 0.5 m from its place, with half of the usual score. So does a good match in
/// doubt that is far from the place before: of 150 robots one drew what it had seen from there,
/// 1.8 m off. And a doubtful one that hardly fits, unless it is within a cell of where odometry has
/// it: two of 200 robots that were carried through walls 0.16 m thick took their backs for their
/// fronts. In doubt such a match begins nothing anew: it may be what refutes the pose.
bool is_carried(const WeighedMatch& weighed, const MotionPrediction& predicted,
                const Expectation& expected) {
  constexpr double kLeast = 0.2;  // [m], as a jump of a second look
  constexpr double kShare =
      0.5;  // of the way: wheels that slip, and logs whose scans are far apart
  constexpr double kHardly = 0.5;      // of the usual score
  constexpr double kWhereSaid = 0.05;  // [m], a cell: odometry speaks for it
  if (!predicted.motion.is_by_odometry || !weighed.match.accepted()) {
    return false;
  }
  const Eigen::Vector2d off =
      weighed.match.map_from_base.translation() - predicted.fixed_from_base.translation();
  const double way = predicted.motion.previous_from_current.translation().norm();
  const bool is_far = off.norm() > std::max(kLeast, kShare * way);
  const double net_fit = weighed.fit - weighed.match.contradiction;
  const bool hardly_fits = !expected.is_in_doubt &&
                           off.norm() > std::max(kWhereSaid, kShare * way) && weighed.fit > 0.0 &&
                           net_fit < kHardly * expected.usual_score;
  return (weighed.upheld && (is_far || hardly_fits)) ||
         ((weighed.overruled || expected.is_in_doubt) && is_far);
}

/// Where a drifted robot drew the map wrong, walls contradict a pose that is right, which would end
/// with a robot that counts as lost. What it saw last contradicts nothing: a scan that fits the
/// newest key scans as well as is usual, about where odometry has it, says that the map is wrong.
/// Only for a while: who is elsewhere draws what it sees there, and fits it. Nor in doubt, which is
/// about the pose.
std::optional<WeighedMatch> overruled_by_newest(const MatchProblem& problem,
                                                const ScanToMatch& to_match,
                                                const EngineOptions& options) {
  constexpr double kMostWay = 1.0;  // [m], a guess: half and double were not tried
  // Some 0.6 m of way. At the mouth of a corridor that was drawn some decimetres too short the
  // newest five contradict 27 % of a scan, two none.
  constexpr std::size_t kNewest = 2;
  const PlacedScans& recent = to_match.recent;
  if (recent.empty() || problem.prior_covariance.isZero(0.0) || to_match.expected.is_in_doubt ||
      to_match.expected.contradicted_way >= kMostWay) {
    return std::nullopt;
  }
  const auto count = static_cast<std::ptrdiff_t>(std::min(kNewest, recent.size()));
  const PlacedScans newest(recent.end() - count, recent.end());
  const SlamMap map = rendered(newest, options.map, options.field);
  std::optional<WeighedMatch> found =
      match_if_convincing({problem.scan, problem.predicted_map_from_base, problem.prior_covariance,
                           map.field, newest, problem.seed},
                          map.occupancy, to_match.expected, options.doubt);
  if (found) {
    found->overruled = true;
    found->match = with_contradiction(found->match, problem, to_match.map.occupancy);
  }
  return found;
}

WeighedMatch match(const ScanMatcher& matcher, const ScanToMatch& to_match,
                   const MotionPrediction& predicted, const EngineOptions& options,
                   bool is_odometry_improbable) {
  const MatchProblem problem{to_match.scan,      predicted.fixed_from_base, predicted.covariance,
                             to_match.map.field, to_match.recent,           to_match.seed};
  if (to_match.map.field.empty()) {
    return {rejected(problem, MatchStatus::kRejectedNoReference)};
  }
  if (to_match.scan.points.size() < static_cast<std::size_t>(options.slam.min_points)) {
    return {rejected(problem, MatchStatus::kRejectedTooFewPoints)};
  }
  WeighedMatch weighed =
      match_and_weigh(matcher, problem, to_match.map.occupancy, to_match.expected, options.doubt);
  if (to_match.may_map_be_wrong && !is_odometry_improbable && predicted.motion.is_by_odometry &&
      weighed.certainty == Certainty::kDoubtful &&
      weighed.match.contradiction > options.doubt.contradiction) {
    weighed = overruled_by_newest(problem, to_match, options).value_or(weighed);
  }
  weighed.jumped = weighed.jumped || is_carried(weighed, predicted, to_match.expected);
  return weighed;
}

/// Whether a second look turned the robot far from where odometry has it: where corridors cross
/// they are alike after a quarter of a turn.
bool is_far_turn(const WeighedMatch& by_odometry, const MotionPrediction& predicted) {
  return by_odometry.jumped &&
         is_turned_far(by_odometry.match.map_from_base, predicted.fixed_from_base);
}

/// Whether the robot may have gone on as it did and not as odometry says. Where scans are rare, one
/// that turns by a radian in a step may be right: the last motion is asked, too, where that leads
/// into doubt or to a far turn. (Not to every jump: what a second look finds is to be confirmed,
/// and the graph knows that the way there is hardly known.)
bool is_to_be_asked(const SteadyPrediction& steady, const WeighedMatch& by_odometry,
                    const MotionPrediction& predicted) {
  if (steady.is_odometry_improbable) {
    return true;
  }
  // What is less than a jump apart is within the window of the other one.
  return is_jump(steady.predicted.fixed_from_base, predicted.fixed_from_base) &&
         (by_odometry.certainty == Certainty::kDoubtful || is_far_turn(by_odometry, predicted));
}

/// Whether a match with the prediction of a steady motion is to be believed and not that with the
/// prediction of odometry; a far turn of that one alone has to be clearly better.
bool is_likelier(const WeighedMatch& steady, const WeighedMatch& by_odometry,
                 const MotionPrediction& predicted, const DoubtOptions& options) {
  // As a second look has to. Half or double changes no byte of six drives with faults and two logs
  // (benchmark/reports/current/CONSTANTS.md).
  constexpr double kClearly = 0.1;
  const bool is_turned = is_far_turn(by_odometry, predicted) && !steady.jumped;
  const double better = is_turned ? -kClearly : kClearly;
  return is_convincing(steady.match, options) &&
         (!by_odometry.match.accepted() ||
          net_score(steady.match) > net_score(by_odometry.match) + better);
}

}  // namespace

WeighedMatch match_likeliest(const ScanMatcher& matcher, const ScanToMatch& scan,
                             const std::optional<SteadyPrediction>& steady,
                             MotionPrediction& predicted, const EngineOptions& options) {
  const bool is_improbable = steady && steady->is_odometry_improbable;
  WeighedMatch by_odometry = match(matcher, scan, predicted, options, is_improbable);
  if (!steady || !is_to_be_asked(*steady, by_odometry, predicted)) {
    return by_odometry;
  }
  WeighedMatch steadily = match(matcher, scan, steady->predicted, options, is_improbable);
  if (!is_likelier(steadily, by_odometry, predicted, options.doubt)) {
    return by_odometry;
  }
  predicted = steady->predicted;
  return steadily;
}

}  // namespace matchbox_slam
