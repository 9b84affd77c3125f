#pragma once

#include <utility>

#include "matchbox_slam/matching/hough/hough_alignment.hpp"
#include "matchbox_slam/matching/refinement.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

struct HoughOptions {
  HoughAlignmentOptions alignment;
  double prior_weight = 0.03;
  double enough_score = 0.5;
  int searched_key_scans = 6;
  double min_score = 0.15;
  RefinementOptions refinement = {5};

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    HoughAlignmentOptions::visit(self.alignment, option);
    option(self.prior_weight, "prior_weight", between(0.0, 10.0), "",
           "Score lost by a pose one standard deviation of the prior away from the prediction.");
    option(self.enough_score, "enough_score", between(0.0, 1.0), "",
           "The next key scan is searched too while the best pose scores less than this.");
    option(self.searched_key_scans, "searched_key_scans", between(1, 100), "",
           "Key scans that are searched at most.");
    option(self.min_score, "min_score", between(0.0, 1.0), "",
           "Matches that explain less of the scan than this are rejected.");
    RefinementOptions::visit(self.refinement, option);
  }
};

/// Scan matching in the Hough domain (Censi, Iocchi and Grisetti 2005), of scan to scan: the
/// rotation and the translation that take the scan's Hough transform to that of a key scan, ranked
/// by likelihood. The best is refined below the size of a cell against the map, where there is one:
/// from scan to scan, as in theirs, errors add up. Cost: columns times points, and what refining
/// costs.
class HoughMatcher : public ScanMatcher {
 public:
  HoughMatcher() = default;
  explicit HoughMatcher(HoughOptions options) : options_(std::move(options)) {}

  void configure(const Parameters& parameters) override;
  [[nodiscard]] std::vector<OptionDescription> options() const override;
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override;

 private:
  HoughOptions options_;
};

}  // namespace matchbox_slam
