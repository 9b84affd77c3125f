#include <gtest/gtest.h>

#include <stdexcept>

#include "simulation/walk.hpp"

namespace matchbox_slam {
namespace {

/// Once around a square of 2 m a side in 4 s, 3 m ahead at time 0.
Walk around_a_square() { return {{{0.0, 0.0}, {2.0, 0.0}, {2.0, 2.0}, {0.0, 2.0}}, 2.0, 3.0}; }

void expect_at(double time, const Eigen::Vector2d& place) {
  EXPECT_LT((around_a_square().at(time) - place).norm(), 1e-6) << time;
}

TEST(Walk, GoesRoundAndRoundAtItsSpeed) {
  expect_at(0.0, {2.0, 1.0});
  expect_at(0.25, {2.0, 1.5});
  expect_at(1.0, {1.0, 2.0});
  expect_at(2.25, {0.0, 0.5});
  expect_at(2.75, {0.5, 0.0});
  expect_at(4.0, {2.0, 1.0});
}

TEST(Walk, GoesOnForEverAndBeforeItsBeginning) {
  expect_at(-1.0, {1.0, 0.0});
  expect_at(-2.0, {0.0, 1.0});
  expect_at(1327500000.25, {2.0, 1.5});
}

TEST(Walk, RefusesAWayOfNoLength) {
  EXPECT_THROW(Walk({}, 1.0, 0.0), std::invalid_argument);
  EXPECT_THROW(Walk({{1.0, 1.0}}, 1.0, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace matchbox_slam
