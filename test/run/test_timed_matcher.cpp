#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <thread>

#include "common/thread_time.hpp"
#include "run/timed_matcher.hpp"

namespace matchbox_slam {
namespace {

/// Works for 5 ms, and is kept from the processor for 100 ms.
class InterruptedMatcher : public ScanMatcher {
 public:
  void configure(const Parameters& /*parameters*/) override {}
  [[nodiscard]] std::vector<OptionDescription> options() const override { return {}; }
  [[nodiscard]] MatchResult match(const MatchProblem& /*problem*/) const override {
    const double begin = thread_seconds();
    while (thread_seconds() - begin < 0.005) {
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return {};
  }
};

TEST(TimedMatcher, CountsTheTimeOnAProcessorAlone) {
  TimedMatcher timed(std::make_shared<InterruptedMatcher>());
  const LikelihoodField field(0.05, LikelihoodFieldOptions{});
  const auto match = [&] {
    (void)timed.match({PointScan{}, Pose2{}, Eigen::Matrix3d::Identity(), field, PlacedScans{}, 1});
  };
  match();
  const double seconds = timed.take_seconds();
  EXPECT_GE(seconds, 0.005);
  EXPECT_LT(seconds, 0.05);
  match();
  match();
  EXPECT_GE(timed.take_seconds(), 0.010) << "matches of one scan add up";
  EXPECT_EQ(timed.take_seconds(), 0.0);
}

}  // namespace
}  // namespace matchbox_slam
