#pragma once

#include "matchbox_slam/matching/refinement.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

struct MonteCarloOptions {
  int max_tries = 1000;
  int max_failed_tries = 100;
  bool reset_on_success = true;
  double enough_score = 0.8;
  double first_area = 1.0;
  double narrowing = 0.85;
  int halve_after = 50;
  int search_points = 150;
  double slope_share = 0.7;
  double prior_weight = 0.03;
  double min_score = 0.15;
  int covariance_samples = 32;
  RefinementOptions refinement;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.max_tries, "max_tries", between(1, 10000000), "", "Poses drawn in all, at most.");
    option(self.max_failed_tries, "max_failed_tries", between(1, 10000000), "",
           "A search ends after this many tries in a row that were no better.");
    option(self.reset_on_success, "reset_on_success", any(), "",
           "A better pose starts the count of failed tries anew, as the text of 'The Scan Matchers "
           "Research and Comparison' says; false: "
           "failed tries count from the beginning, as in its listing.");
    option(self.enough_score, "enough_score", between(0.0, 1.0), "",
           "The search starts again from the prediction, while tries are left, until the best pose "
           "of all scores this much; 0: it never does; 1: until all tries are spent.");
    option(self.first_area, "first_area", between(1e-3, 100.0), "",
           "Spread of the first draws, in standard deviations of the prior.");
    option(self.narrowing, "narrowing", between(0.01, 1.0), "",
           "The area shrinks by this factor with every better pose; 1: it does not.");
    option(
        self.halve_after, "halve_after", between(0, 10000000), "",
        "The area is also halved after this many failed tries in a row, as in tinySLAM; 0: never.");
    option(self.search_points, "search_points", between(10, 1000000), "",
           "Points that are looked up for each pose, spread evenly along the walls.");
    option(
        self.slope_share, "slope_share", between(0.0, 1.0), "",
        "Share of the long slope (the distance to the nearest wall) in the score; the rest is the "
        "narrow Gaussian.");
    option(self.prior_weight, "prior_weight", between(0.0, 10.0), "",
           "Score lost by a pose one standard deviation of the prior away from the prediction.");
    option(self.min_score, "min_score", between(0.0, 1.0), "",
           "Matches that explain less of the scan than this are rejected.");
    option(self.covariance_samples, "covariance_samples", between(0, 100000), "",
           "Poses around the answer, two for each, whose scores make its covariance; 0: the "
           "curvature alone makes it.");
    RefinementOptions::visit(self.refinement, option);
  }
};

/// The Monte-Carlo matcher of "The Scan Matchers Research and Comparison: Monte-Carlo, Olson and
/// Hough", after tinySLAM (Steux and El Hamzaoui 2010): poses are drawn at random around the best
/// one so far; a better one becomes the new centre, resets the count of failed tries and narrows
/// the area. A search ends after `max_failed_tries` in a row, all searching after `max_tries`.
/// Deviations:
///  - Draws are Gaussian with the prior's covariance, times an area that starts at `first_area`.
///  - The area is also halved after `halve_after` failed tries in a row, as in tinySLAM.
///  - The cost of a pose is read from the likelihood field, by how far from a wall each point falls
///    (`slope_share`), instead of from the cells' occupancy.
///  - Of the points some `search_points` are looked up, one for each equal length of wall.
///  - A pose pays for its distance from the prediction (`prior_weight`), along the prior's axes.
///  - A search whose answer fits badly (`enough_score`) is begun again from the prediction with the
///    tries that are left; the best of all counts.
///  - A sub-cell refinement ends it.
/// Cost: search points times tries, and beams times refinement steps.
class MonteCarloMatcher : public ScanMatcher {
 public:
  MonteCarloMatcher() = default;
  explicit MonteCarloMatcher(const MonteCarloOptions& options) : options_(options) {}

  void configure(const Parameters& parameters) override;
  [[nodiscard]] std::vector<OptionDescription> options() const override;
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override;

 private:
  MonteCarloOptions options_;
};

}  // namespace matchbox_slam
