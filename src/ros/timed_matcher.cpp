#include "matchbox_slam/ros/timed_matcher.hpp"

#include <chrono>
#include <stdexcept>
#include <utility>

namespace matchbox_slam {

TimedMatcher::TimedMatcher(std::shared_ptr<const ScanMatcher> matcher)
    : matcher_(std::move(matcher)) {}

void TimedMatcher::configure(const Parameters& /*parameters*/) {
  throw std::logic_error("a timed matcher is configured before it is timed");
}

std::vector<OptionDescription> TimedMatcher::options() const { return matcher_->options(); }

MatchResult TimedMatcher::match(const MatchProblem& problem) const {
  const auto begin = std::chrono::steady_clock::now();
  MatchResult result = matcher_->match(problem);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  seconds_.store(elapsed.count());
  return result;
}

}  // namespace matchbox_slam
