#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "evaluation/error_statistics.hpp"

namespace matchbox_slam {
namespace {

TEST(Quantile, InterpolatesBetweenRanks) {
  EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 3.0, 2.0}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 3.0, 2.0}, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 3.0, 2.0}, 1.0), 4.0);
  EXPECT_DOUBLE_EQ(quantile({0.0, 10.0}, 0.95), 9.5);
  EXPECT_DOUBLE_EQ(quantile({7.0}, 0.95), 7.0);
  EXPECT_THROW((void)quantile({}, 0.5), std::invalid_argument);
}

TEST(SummarizeErrors, AgreesWithHandComputation) {
  const ErrorStatistics statistics = summarize_errors({3.0, 0.0, 4.0, 1.0, 2.0});
  EXPECT_EQ(statistics.count, 5U);
  EXPECT_DOUBLE_EQ(statistics.rmse, std::sqrt(6.0));
  EXPECT_DOUBLE_EQ(statistics.mean, 2.0);
  EXPECT_DOUBLE_EQ(statistics.median, 2.0);
  EXPECT_DOUBLE_EQ(statistics.p95, 3.8);
  EXPECT_DOUBLE_EQ(statistics.max, 4.0);
  EXPECT_THROW((void)summarize_errors({}), std::invalid_argument);
}

}  // namespace
}  // namespace matchbox_slam
