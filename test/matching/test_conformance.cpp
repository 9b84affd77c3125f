// Of matching/scan_matcher.hpp: the conformance suite over the matchers of this package, without
// plugins.

#include <gtest/gtest.h>

#include <memory>

#include "matchbox_slam/matching/hough/hough_matcher.hpp"
#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"
#include "matchbox_slam/matching/odometry_only_matcher.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matching/matcher_conformance.hpp"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  using matchbox_slam::register_matcher_conformance;
  register_matcher_conformance("Hough",
                               [] { return std::make_shared<matchbox_slam::HoughMatcher>(); });
  register_matcher_conformance("MonteCarlo",
                               [] { return std::make_shared<matchbox_slam::MonteCarloMatcher>(); });
  register_matcher_conformance(
      "OdometryOnly", [] { return std::make_shared<matchbox_slam::OdometryOnlyMatcher>(); });
  register_matcher_conformance("Olson",
                               [] { return std::make_shared<matchbox_slam::OlsonMatcher>(); });
  return RUN_ALL_TESTS();
}
