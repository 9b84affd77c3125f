#include "run/timed_matcher.hpp"

#include <stdexcept>
#include <utility>

#include "common/thread_time.hpp"

namespace matchbox_slam {

TimedMatcher::TimedMatcher(std::shared_ptr<const ScanMatcher> matcher)
    : matcher_(std::move(matcher)) {}

void TimedMatcher::configure(const Parameters& /*parameters*/) {
  throw std::logic_error("a timed matcher is configured before it is timed");
}

std::vector<OptionDescription> TimedMatcher::options() const { return matcher_->options(); }

MatchResult TimedMatcher::match(const MatchProblem& problem) const {
  const double begin = thread_seconds();
  MatchResult result = matcher_->match(problem);
  const double seconds = thread_seconds() - begin;
  // C++17 adds to no atomic number with a fraction; matchers are asked from several threads.
  for (double sum = seconds_.load(); !seconds_.compare_exchange_weak(sum, sum + seconds);) {
  }
  return result;
}

}  // namespace matchbox_slam
