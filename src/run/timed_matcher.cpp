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
  seconds_.store(seconds_.load() + thread_seconds() - begin);
  return result;
}

}  // namespace matchbox_slam
