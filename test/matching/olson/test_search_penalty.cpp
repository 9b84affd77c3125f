#include <gtest/gtest.h>

#include <algorithm>

#include "matchbox_slam/common/random.hpp"
#include "matching/olson/search_penalty.hpp"

namespace matchbox_slam {
namespace {

StepRange random_range(Random& random, int longest) {
  const int first = static_cast<int>(random.uniform(-30.0, 30.0));
  return {first, first + static_cast<int>(random.uniform() * longest)};
}

/// Of any rank, with any coupling.
Eigen::Matrix3d random_information(Random& random) {
  const int rank = 1 + static_cast<int>(random.uniform() * 3.0);
  Eigen::Matrix3d root = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3 * rank; ++i) {
    root(i % 3, i / 3) = random.uniform(-1.0, 1.0);
  }
  return root * root.transpose();
}

TEST(SearchPenalty, HasTheLeastOfEachBoxOfPoses) {
  Random random(5);
  for (int box = 0; box < 3000; ++box) {
    SCOPED_TRACE("box " + std::to_string(box));
    SearchLattice lattice;
    lattice.step_theta = 0.05;
    SearchScoring scoring;
    scoring.prior_information = random_information(random);
    scoring.prior_weight = 1e5;
    const SearchPenalty penalty(lattice, scoring, 0.05);
    const StepRange x = random_range(random, 12);
    const StepRange y = random_range(random, 12);
    const StepRange theta = random_range(random, 6);
    std::int64_t least = kMaxPenalty;
    for (int t = theta.first; t <= theta.last; ++t) {
      for (int i = x.first; i <= x.last; ++i) {
        for (int j = y.first; j <= y.last; ++j) {
          least = std::min(least, penalty.at({i, j, t}));
        }
      }
    }
    ASSERT_LE(penalty.least(x, y, theta), least);
    ASSERT_LE(penalty.least(theta), least);
    if (x.count() == 1 && y.count() == 1) {  // no pose is between these
      ASSERT_GE(penalty.least(x, y, theta), theta.count() == 1 ? least - 1 : least / 2 - 1);
    }
  }
}

}  // namespace
}  // namespace matchbox_slam
