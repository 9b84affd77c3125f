#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

/// Any matcher, and the time that its matches had on a processor, which other programs do not
/// change. Everything else is as the matcher itself has it.
class TimedMatcher : public ScanMatcher {
 public:
  explicit TimedMatcher(std::shared_ptr<const ScanMatcher> matcher);

  /// Throws std::logic_error: the matcher inside is configured already.
  void configure(const Parameters& parameters) override;
  [[nodiscard]] std::vector<OptionDescription> options() const override;
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override;

  /// Of the matches since this was asked last [s]: a scan may take two, or none.
  double take_seconds() { return seconds_.exchange(0.0); }

 private:
  std::shared_ptr<const ScanMatcher> matcher_;
  mutable std::atomic<double> seconds_{0.0};
};

}  // namespace matchbox_slam
