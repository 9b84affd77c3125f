#pragma once

#include <matchbox_slam/matching/refinement.hpp>
#include <matchbox_slam/matching/scan_matcher.hpp>
#include <vector>

namespace example_matcher {

struct HillClimbingOptions {
  double first_step = 1.0;
  int halvings = 5;
  double min_score = 0.25;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    using matchbox_slam::between;
    option(self.first_step, "first_step", between(1e-3, 100.0), "",
           "Length of the first steps, in standard deviations of the prior.");
    option(self.halvings, "halvings", between(0, 30), "", "How often the step is halved.");
    option(self.min_score, "min_score", between(0.0, 1.0), "",
           "Matches that explain less of the scan than this are rejected.");
  }
};

/// Walks uphill: from the prediction, a step along each axis of the prior's covariance, as long as
/// the scan fits better; then steps half as long. Gets stuck on the first hill. Cost: beams times
/// steps.
class HillClimbingMatcher : public matchbox_slam::ScanMatcher {
 public:
  void configure(const matchbox_slam::Parameters& parameters) override;
  [[nodiscard]] std::vector<matchbox_slam::OptionDescription> options() const override;
  [[nodiscard]] matchbox_slam::MatchResult match(
      const matchbox_slam::MatchProblem& problem) const override;

 private:
  HillClimbingOptions options_;
};

}  // namespace example_matcher
