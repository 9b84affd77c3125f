#include "slam/pose_hypotheses.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "matchbox_slam/geometry/chi_square.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matching/wide_search.hpp"
#include "slam/common_ground.hpp"
#include "slam/prior_odds.hpp"
#include "slam/scan_evidence.hpp"
#include "slam/scan_profile.hpp"

namespace matchbox_slam {
namespace {

/// [m] or [rad], from one search to the next.
constexpr double kSearchSpacing = 0.2;
/// [m] without a scan that tells hypotheses apart, after which the leading one is believed.
constexpr double kMaxUndecidedWay = 10.0;
constexpr std::size_t kMostOthers = 4;

double limited(double log_odds) { return std::clamp(log_odds, -kMostOfScan, kMostOfScan); }

/// What a scan says for a pose and against the leading one, by the evidence of each. How much
/// better it is explained and how much less it is contradicted are limited by themselves: a wrong
/// pose often explains a scan, as rooms are alike, and a right one is hardly ever contradicted.
double relative_log_odds(double there, double leading) {
  const double explained = std::max(there, 0.0) - std::max(leading, 0.0);
  const double contradicted = std::min(leading, 0.0) - std::min(there, 0.0);
  return limited(explained) - limited(contradicted);
}

/// How much of an independent scan it is: from one place scans repeat their errors.
double independence_of(const PoseHypotheses::Step& step) {
  constexpr double kDistance = 0.3;  // [m]
  constexpr double kAngle = 0.3;     // [rad]
  constexpr double kTime = 2.0;      // [s], as what stands in the way goes on
  const Pose2& moved = step.predicted.motion.previous_from_current;
  return std::min(1.0, moved.translation().norm() / kDistance + std::abs(moved.theta) / kAngle +
                           step.seconds / kTime);
}

bool is_same(const Pose2& a, const Pose2& b) { return are_near(a, b, 0.1, 0.05); }

bool is_refuted(double log_odds, const HypothesisOptions& options) {
  return log_odds < -kPriorAgainstJump - options.decisive;
}

/// Where a hypothesis goes on: [m], [rad] that it may be off besides its motion.
Eigen::Matrix3d covariance_around(const MotionEstimate& motion) {
  return motion.unscaled + covariance_of(0.1, 0.05);
}

MatchProblem problem_at(const PoseHypotheses::Step& step, const Pose2& map_from_base,
                        const Eigen::Matrix3d& covariance) {
  return {step.scan, map_from_base, covariance, step.map.field, step.recent, 0};
}

double squared_distance(const Pose2& pose, const MotionPrediction& predicted) {
  const Eigen::Vector3d off = difference(pose, predicted.fixed_from_base);
  return off.dot(predicted.search_covariance.ldlt().solve(off));
}

}  // namespace

bool PoseHypotheses::is_jump(const MatchResult& match, const MotionPrediction& predicted) {
  return match.accepted() && squared_distance(match.map_from_base, predicted) > kMostChiSquare;
}

PoseHypotheses::Outcome PoseHypotheses::follow(const Step& step, MatchResult match,
                                               const HypothesisOptions& options) {
  Outcome outcome;
  outcome.match = std::move(match);
  outcome.evidence = evidence_of(step.scan, outcome.match.map_from_base, step.map);
  if (!options.enabled || step.scan.points.empty()) {
    leave_out(step.predicted.motion);
    return outcome;
  }
  const double share = std::max(independence_of(step), note_change(step));
  const std::optional<PoseHypothesis> refused = refuse_unexpected(step, options, outcome);
  outcome.is_jump = is_jump(outcome.match, step.predicted);
  weigh_others(step, outcome.evidence.log_odds, share);
  note_motion(step, outcome.evidence.log_odds);
  if (is_search_due(outcome, step.steady.has_value())) {
    begin_fork(step);
    state_.fork->searched = 0.0;
    search(step, outcome, share);
  }
  if (refused) {
    begin_fork(step);
    // One that is there already has its odds, of more than this scan.
    if (same_as(refused->map_from_base) == state_.others.end()) {
      add(refused->map_from_base, refused->log_odds);
      keep_likeliest();
    }
  }
  weigh_elsewhere(step, share * odds_of_elsewhere(outcome.evidence), outcome);
  drop_refuted(outcome.match.map_from_base, options);
  decide(step, options, outcome);
  return outcome;
}

void PoseHypotheses::leave_out(const MotionEstimate& motion) {
  state_.profile = {};
  move_others(motion.previous_from_current);
}

void PoseHypotheses::move_others(const Pose2& previous_from_current) {
  for (PoseHypothesis& other : state_.others) {
    other.map_from_base = other.map_from_base * previous_from_current;
  }
}

/// The share of what it sees in which a scan is another one than that before. Whatever the odometry
/// says: a robot that is carried sees something else with each, and errors do not repeat.
double PoseHypotheses::note_change(const Step& step) {
  const ScanProfile profile = profile_of(step.scan);
  const double changed =
      changed_share(profile, state_.profile, step.predicted.motion.previous_from_current);
  state_.profile = profile;
  return changed;
}

/// A jump makes it possible that the robot was carried, and not more: where it is now the scan
/// tells.
void PoseHypotheses::weigh_elsewhere(const Step& step, double odds, const Outcome& outcome) {
  double& elsewhere = state_.elsewhere;
  elsewhere = std::max(-kPriorAgainstCarried, elsewhere);
  elsewhere = std::max(-kPriorAgainstCarried, elsewhere + odds);
  if (outcome.is_jump) {
    const double raised =
        elsewhere + 0.5 * squared_distance(outcome.match.map_from_base, step.predicted);
    elsewhere = std::max(elsewhere, std::min(0.0, raised));
  }
}

/// What is found where the motion hardly leads to has to be likelier than what the motion tells:
/// evidence, in the map that it was found in, and prior decide which of both leads. Poses that
/// evidence can hardly tell apart are the match's to decide.
/// @returns the match, as another hypothesis, where it does not lead and may be right.
std::optional<PoseHypothesis> PoseHypotheses::refuse_unexpected(const Step& step,
                                                                const HypothesisOptions& options,
                                                                Outcome& outcome) {
  MatchResult& match = outcome.match;
  const Pose2& expected = step.predicted.fixed_from_base;
  if (!match.accepted() || is_same(match.map_from_base, expected)) {
    return std::nullopt;
  }
  MatchProblem problem = problem_at(step, expected, step.predicted.covariance);
  problem.search_covariance = step.predicted.search_covariance;
  if (!is_unexpected(problem, match.map_from_base)) {
    return std::nullopt;
  }
  const double for_match =
      evidence_between(step.scan, match.map_from_base, expected, step.matched) +
      prior_log_odds(problem, match.map_from_base);
  if (for_match >= 0.0) {
    return std::nullopt;
  }
  const PoseHypothesis refused{match.map_from_base, for_match};
  const std::size_t candidates = match.candidates;
  match = rejected(problem, MatchStatus::kRejectedUnexpected);
  match.candidates = candidates;
  outcome.evidence = evidence_of(step.scan, expected, step.map);
  return is_refuted(for_match, options) ? std::nullopt : std::optional(refused);
}

void PoseHypotheses::weigh_others(const Step& step, double leading, double share) {
  const MotionEstimate& motion = step.predicted.motion;
  move_others(motion.previous_from_current);
  for (PoseHypothesis& other : state_.others) {
    other.map_from_base =
        search_exactly(problem_at(step, other.map_from_base, covariance_around(motion)))
            .map_from_base;
    const ScanEvidence there = evidence_of(step.scan, other.map_from_base, step.map);
    other.log_odds += share * relative_log_odds(there.log_odds, leading);
  }
}

void PoseHypotheses::note_motion(const Step& step, double leading) {
  if (!state_.fork) {
    return;
  }
  const Pose2& moved = step.predicted.motion.previous_from_current;
  const double distance = moved.translation().norm();
  state_.fork->searched += distance + std::abs(moved.theta);
  // What lies on unknown ground says nothing of any of them.
  const bool says_something = std::abs(leading) > 1.0;
  state_.fork->undecided = says_something ? 0.0 : state_.fork->undecided + distance;
}

bool PoseHypotheses::is_search_due(const Outcome& outcome, bool is_odometry_improbable) const {
  const bool is_bad = is_badly_explained(outcome.evidence);
  return is_odometry_improbable ||
         ((is_bad || outcome.is_jump) && (!state_.fork || state_.fork->searched >= kSearchSpacing));
}

/// Adds the pose that the last motion leads to, where ground that both poses know speaks for it.
/// Odometry that catches up is right, though its step is improbable: by all beams the pose behind
/// would win, as more is known there. Once added it competes as any other.
void PoseHypotheses::consider_steady(const Step& step, const Pose2& leading, double share) {
  constexpr double kPrior = 0.5 * kMostChiSquare - kPriorAgainstJump;  // the step's own odds, too
  const MatchResult match = search_exactly(
      problem_at(step, step.steady->fixed_from_base, step.steady->search_covariance));
  if (!match.accepted() || is_same(match.map_from_base, leading)) {
    return;
  }
  const double there = evidence_of(step.scan, match.map_from_base, step.map).log_odds;
  const double error = kModelErrorShare * std::max(0.0, there);
  const double better = evidence_between(step.scan, match.map_from_base, leading, step.map) - error;
  if (better > 0.0) {
    add(match.map_from_base, kPrior + share * limited(better));
  }
}

void PoseHypotheses::search(const Step& step, const Outcome& outcome, double share) {
  const Pose2& leading = outcome.match.map_from_base;
  const double for_leading = outcome.evidence.log_odds;
  if (step.steady) {
    consider_steady(step, leading, share);
  }
  for (const MatchResult& match :
       search_widely(problem_at(step, step.predicted.fixed_from_base, step.predicted.covariance))) {
    if (!match.accepted() || is_same(match.map_from_base, leading)) {
      continue;
    }
    const double there = evidence_of(step.scan, match.map_from_base, step.map).log_odds;
    if (there > for_leading) {
      add(match.map_from_base, share * relative_log_odds(there, for_leading) - kPriorAgainstJump);
    }
  }
  keep_likeliest();
}

void PoseHypotheses::keep_likeliest() {
  std::vector<PoseHypothesis>& others = state_.others;
  std::stable_sort(others.begin(), others.end(),
                   [](const auto& a, const auto& b) { return a.log_odds > b.log_odds; });
  others.resize(std::min(others.size(), kMostOthers));
}

void PoseHypotheses::begin_fork(const Step& step) {
  if (!state_.fork) {
    state_.fork = HypothesesFork{step.key_scans.size()};
    state_.fork->searched = kSearchSpacing;  // nothing was yet
  }
}

std::vector<PoseHypothesis>::iterator PoseHypotheses::same_as(const Pose2& map_from_base) {
  return std::find_if(state_.others.begin(), state_.others.end(), [&](const auto& other) {
    return is_same(other.map_from_base, map_from_base);
  });
}

void PoseHypotheses::add(const Pose2& map_from_base, double log_odds) {
  const auto same = same_as(map_from_base);
  if (same != state_.others.end()) {
    same->log_odds = std::max(same->log_odds, log_odds);
    return;
  }
  state_.others.push_back(
      {map_from_base, log_odds, std::vector<std::optional<Pose2>>(state_.fork->inserted)});
}

void PoseHypotheses::drop_refuted(const Pose2& leading, const HypothesisOptions& options) {
  std::vector<PoseHypothesis>& others = state_.others;
  const auto is_over = [&](const PoseHypothesis& other) {
    return is_refuted(other.log_odds, options) || is_same(other.map_from_base, leading);
  };
  others.erase(std::remove_if(others.begin(), others.end(), is_over), others.end());
}

void PoseHypotheses::decide(const Step& step, const HypothesisOptions& options, Outcome& outcome) {
  const auto best =
      std::max_element(state_.others.begin(), state_.others.end(),
                       [](const auto& a, const auto& b) { return a.log_odds < b.log_odds; });
  const double better = best == state_.others.end() ? 0.0 : std::max(0.0, best->log_odds);
  if (better > options.decisive) {
    lead(best, step, outcome);
  } else if (state_.elsewhere - better >= options.decisive) {
    outcome.verdict = Verdict::kUnknown;
  } else if (state_.fork && ((state_.others.empty() && state_.elsewhere <= -kPriorAgainstCarried) ||
                             state_.fork->undecided > kMaxUndecidedWay)) {
    believe();
  }
}

/// The one that led before goes on as another one.
void PoseHypotheses::lead(std::vector<PoseHypothesis>::iterator overtaking, const Step& step,
                          Outcome& outcome) {
  const PoseHypothesis leading = std::move(*overtaking);
  state_.others.erase(overtaking);
  for (PoseHypothesis& other : state_.others) {
    other.log_odds -= leading.log_odds;
  }
  PoseHypothesis before{outcome.match.map_from_base, -leading.log_odds};
  for (std::size_t i = 0; i < state_.fork->inserted; ++i) {
    before.key_scans.emplace_back(step.key_scans[state_.fork->key_scans + i].map_from_base);
  }
  state_.others.push_back(std::move(before));
  state_.elsewhere = std::max(-kPriorAgainstCarried, state_.elsewhere - leading.log_odds);
  constexpr double kSigmaXy = 0.05;     // [m], how well it is known before it is refined
  constexpr double kSigmaTheta = 0.03;  // [rad]
  outcome.verdict = Verdict::kOvertaken;
  outcome.before = outcome.match.map_from_base;
  outcome.match =
      search_exactly(problem_at(step, leading.map_from_base, covariance_of(kSigmaXy, kSigmaTheta)));
  outcome.key_scans = leading.key_scans;
}

bool PoseHypotheses::is_in_doubt(const HypothesisOptions& options) const {
  const auto is_possible = [&](double log_odds) { return log_odds > -options.decisive; };
  return is_forked() &&
         (is_possible(state_.elsewhere) ||
          std::any_of(state_.others.begin(), state_.others.end(),
                      [&](const auto& other) { return is_possible(other.log_odds); }));
}

Eigen::Matrix3d PoseHypotheses::spread_around(const Pose2& leading) const {
  double all = 1.0;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const PoseHypothesis& other : state_.others) {
    const double odds = std::exp(std::min(other.log_odds, kMostOfScan));
    const Eigen::Vector3d apart = difference(other.map_from_base, leading);
    spread += odds * apart * apart.transpose();
    all += odds;
  }
  return spread / all;
}

void PoseHypotheses::note_key_scans(const PlacedScans& all, const Pose2& leading) {
  if (!state_.fork) {
    return;
  }
  for (; state_.fork->key_scans + state_.fork->inserted < all.size(); ++state_.fork->inserted) {
    const PlacedScan& key = all[state_.fork->key_scans + state_.fork->inserted];
    const Pose2 base_from_key = leading.inverse() * key.map_from_base;
    for (PoseHypothesis& other : state_.others) {
      other.key_scans.emplace_back(other.map_from_base * base_from_key);
    }
  }
}

void PoseHypotheses::forget_key_scans() {
  state_.fork->inserted = 0;
  for (PoseHypothesis& other : state_.others) {
    other.key_scans.clear();
  }
}

void PoseHypotheses::begin_lost() {
  believe();
  state_.elsewhere = 0.0;
}

void PoseHypotheses::believe() {
  state_.fork.reset();
  state_.others.clear();
  state_.elsewhere = -std::numeric_limits<double>::infinity();
}

}  // namespace matchbox_slam
