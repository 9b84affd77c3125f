#pragma once

#include <string>

#include "matchbox_slam/common/object_pool.hpp"
#include "matchbox_slam/matching/refinement.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

struct OlsonOptions {
  double step_xy = 0.025;
  double step_theta = 0.0;
  double window_xy = 0.0;
  double window_theta = 0.0;
  double window_sigmas = 3.0;
  double max_window_xy = 5.0;
  std::string likelihood = "linear";
  double outliers = 0.05;
  std::string weighting = "walls";
  double point_spacing = 0.025;
  double prior_weight = 0.03;
  double min_score = 0.15;
  double search_floor = 0.0;
  double rival_distance = 0.3;
  double least_rival = 0.8;
  double deadline = 0.0;
  int most_look_ups = 2000000;
  RefinementOptions refinement;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.step_xy, "step_xy", between(1e-3, 1.0), "m",
           "Largest step of translation; the step is a cell divided by a whole number up to 16.");
    option(self.step_theta, "step_theta", between(0.0, 1.0), "rad",
           "Step of rotation; 0: the farthest useful point moves by one step of translation.");
    option(self.window_xy, "window_xy", between(0.0, 100.0), "m",
           "Half width of the search around the prediction; 0: window_sigmas of the prior.");
    option(self.window_theta, "window_theta", between(0.0, 3.15), "rad",
           "Half width of the search around the predicted heading; 0: window_sigmas of the prior.");
    option(self.window_sigmas, "window_sigmas", between(0.1, 10.0), "",
           "Half width of a window from the prior, in the prior's standard deviations.");
    option(self.max_window_xy, "max_window_xy", between(0.05, 100.0), "m",
           "Largest half width of a window from the prior.");
    option(self.likelihood, "likelihood", one_of({"linear", "log"}), "",
           "linear: the mean likelihood of the points, robust; log: the product of their "
           "likelihoods, as in Olson (2009).");
    option(
        self.outliers, "outliers", between(1e-4, 0.9), "",
        "With log: share of points that may fall anywhere, so that one alone rules nothing out.");
    option(self.weighting, "weighting", one_of({"walls", "beams"}), "",
           "walls: points count by the length of wall that they stand for; beams: all alike.");
    option(self.point_spacing, "point_spacing", between(0.0, 1.0), "m",
           "Neighbouring points closer than this are searched as one; 0: every point for itself.");
    option(self.prior_weight, "prior_weight", between(0.0, 10.0), "",
           "Score lost by a pose one standard deviation of the prior away from the prediction.");
    option(self.min_score, "min_score", between(0.0, 1.0), "",
           "Matches that explain less of the scan than this are rejected.");
    option(self.search_floor, "search_floor", between(0.0, 1.0), "",
           "Poses that explain less of the scan than this, before they are refined, are not looked "
           "for, which ends the search sooner where nothing fits; 0: any.");
    option(self.rival_distance, "rival_distance", between(0.05, 10.0), "m",
           "Poses this far from the best one, or by the angle that moves the points as far, may be "
           "its rivals.");
    option(self.least_rival, "least_rival", between(0.0, 1.0), "",
           "Rivals with less than this share of the best score are not looked for; 1: none is.");
    option(self.deadline, "deadline", between(0.0, 100.0), "s",
           "The search ends after this time with the best so far, which then depends on the "
           "machine; 0: never.");
    option(self.most_look_ups, "most_look_ups", between(0, 2000000000), "",
           "The search ends with the best so far after so many look-ups of points, each in up to "
           "16 cells at once and of some nanoseconds, which are the same on all machines; 0: "
           "never.");
    RefinementOptions::visit(self.refinement, option);
  }
};

/// Real-time correlative scan matching (Olson 2009): the pose that maximises the likelihood of the
/// scan times the prior over a window around the prediction, with proof that nothing on the search
/// lattice is better, then refined below the size of a step. Where the best pose has a distant
/// rival, the covariance covers both. Cost: groups of rotations times points times the window's
/// width in blocks, plus what the bounds leave open.
///
/// Deviations from Olson: the reference is the map's likelihood field, which is kept up to date
/// and not rendered for each scan; likelihoods are added by default and not multiplied, which
/// forgives points that fit nothing; near points are merged.
class OlsonMatcher : public ScanMatcher {
 public:
  explicit OlsonMatcher(OlsonOptions options = {});
  ~OlsonMatcher() override;

  void configure(const Parameters& parameters) override;
  [[nodiscard]] std::vector<OptionDescription> options() const override;
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override;

  struct Memory;

 private:
  OlsonOptions options_;
  mutable ObjectPool<Memory> memory_;
};

}  // namespace matchbox_slam
