#include "matchbox_slam/matching/olson/olson_matcher.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "matching/olson/window_search.hpp"

namespace matchbox_slam {

/// What a match works in.
struct OlsonMatcher::Memory {
  WindowSearchMemory search;
  Correspondences pairs;
  std::vector<Eigen::Vector3d> steps;
  std::vector<std::array<double, 2>> costs;
};

namespace {

/// Second moment of the posterior around the answer, from its score on a grid of 5 x 5 x 5 poses as
/// wide as two standard deviations to each side (Olson 2009, section III-D).
Eigen::Matrix3d volume_covariance(const LocalPosterior& posterior,
                                  const Eigen::Matrix3d& covariance, OlsonMatcher::Memory& memory) {
  const Eigen::Matrix3d spread = covariance.llt().matrixL();
  // Standard deviations; the grid's moment of a Gaussian is then 0.96 of its variance. The mean
  // NEES of pairs in rooms, 3 if honest, is 3.3; with half of this 6.8, with double 4.2.
  constexpr double kSpacing = 1.1;
  constexpr int kSide = 5;
  // Half of the grid: with each step its opposite is looked at, too.
  std::vector<Eigen::Vector3d>& steps = memory.steps;
  steps.clear();
  for (int i = 0; i < kSide * kSide * kSide / 2; ++i) {
    const int layer = i / (kSide * kSide);
    const Eigen::Vector3d at(i % kSide, i / kSide % kSide, layer);
    steps.emplace_back(spread * (kSpacing * (at.array() - kSide / 2).matrix()));
  }
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  double total = 1.0;  // the answer itself
  const std::vector<std::array<double, 2>>& costs = memory.costs;
  posterior.costs_of_both(steps, memory.costs);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto weight = [](double cost) { return std::exp(std::min(30.0, -cost)); };
    const double both = weight(costs[i][0]) + weight(costs[i][1]);
    moment += both * steps[i] * steps[i].transpose();
    total += both;
  }
  return moment / total;
}

/// The covariance of a pose that is at the answer or at its rival, which are as likely when they
/// score the same; the rival soon becomes less likely when it scores less.
Eigen::Matrix3d with_rival(const Eigen::Matrix3d& covariance, const Pose2& answer,
                           const Pose2& rival, double score_difference) {
  // Difference in score, as a share of the highest one, by which a rival is e times less likely.
  // The pairs and intel have no rivals: half or double changes nothing there.
  constexpr double kDecay = 0.01;
  const double odds = std::exp(-std::max(0.0, score_difference) / kDecay);
  const double share = odds / (1.0 + odds);
  const Eigen::Vector3d apart = difference(rival, answer);
  return covariance + share * (1.0 - share) * apart * apart.transpose();
}

}  // namespace

OlsonMatcher::OlsonMatcher(OlsonOptions options) : options_(std::move(options)) {}

OlsonMatcher::~OlsonMatcher() = default;

void OlsonMatcher::configure(const Parameters& parameters) {
  options_ = read_options<OlsonOptions>(parameters, "olson");
}

std::vector<OptionDescription> OlsonMatcher::options() const { return describe_options(options_); }

MatchResult OlsonMatcher::match(const MatchProblem& problem) const {
  if (const std::optional<MatchResult> rejection = reject_unmatchable(problem)) {
    return *rejection;
  }
  const ObjectPool<Memory>::Handle memory = memory_.acquire();
  const FoundInWindow found = find_in_window(problem, options_, memory->search);
  MatchResult result = rejected(problem, MatchStatus::kRejectedLowScore);
  result.candidates = found.candidates;
  result.proof = found.proof;
  if (!found.is_any) {
    return result;
  }
  const PosePrior prior{problem.predicted_map_from_base, problem.prior_covariance};
  Correspondences& pairs = memory->pairs;
  pairs.assign(problem.scan.points, problem.field, found.proof.map_from_base);
  const RefinedPose refined = refine(pairs, found.proof.map_from_base, prior, options_.refinement);
  if (std::isfinite(refined.score)) {
    result.score = std::clamp(refined.score, 0.0, 1.0);
  }
  result.rival_share = found.rival_share;
  if (!(refined.score >= options_.min_score)) {
    return result;
  }
  result.status = MatchStatus::kAccepted;
  result.map_from_base = refined.map_from_base;
  result.refined_by = difference(refined.map_from_base, found.proof.map_from_base);
  result.unconstrained_directions = refined.unconstrained_directions;
  const bool is_held = refined.unconstrained_directions.empty();
  result.covariance =
      is_held ? volume_covariance({pairs, refined.map_from_base, prior, options_.refinement},
                                  refined.covariance, *memory)
              : refined.covariance;
  if (found.rival && is_held) {
    result.covariance = with_rival(result.covariance, found.proof.map_from_base, *found.rival,
                                   found.proof.best_score * (1.0 - found.rival_share));
  }
  if (options_.refinement.iterations == 0) {
    // The likelihoods are those of cells, which steps finer than these tell hardly apart.
    const double coarser = std::max(1.0, problem.field.geometry().resolution() / found.step_xy);
    result.covariance += step_covariance(coarser * found.step_xy, coarser * found.step_theta);
  }
  // What was not looked at may be the truth, anywhere that the prior allows. A mixture, and no sum:
  // in a corridor the prior is all that is known of the way along it, scan after scan.
  const double unseen = found.proof.gap() > 0.0 ? 1.0 : found.share_beyond;
  result.covariance = (1.0 - unseen) * result.covariance + unseen * problem.prior_covariance;
  return result;
}

}  // namespace matchbox_slam
