#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "simulation/corridor_net.hpp"

namespace matchbox_slam {
namespace {

/// Two squares of 10 m side by side, and a blind alley of 3 m.
CorridorNet two_loops() {
  CorridorNet net;
  for (const double x : {0.0, 10.0}) {
    net.add({x, 0.0}, {x + 10.0, 0.0});
    net.add({x, 10.0}, {x + 10.0, 10.0});
  }
  for (const double x : {0.0, 10.0, 20.0}) {
    net.add({x, 0.0}, {x, 10.0});
  }
  net.add({20.0, 10.0}, {23.0, 10.0});
  return net;
}

double length_of(const CorridorNet& net, const std::vector<std::size_t>& tour) {
  double length = 0.0;
  for (std::size_t i = 1; i < tour.size(); ++i) {
    length += (net.crossings()[tour[i]] - net.crossings()[tour[i - 1]]).norm();
  }
  return length;
}

TEST(CorridorNet, CorridorsMeetAtCrossings) {
  const CorridorNet net = two_loops();
  EXPECT_EQ(net.corridors().size(), 8U);
  EXPECT_EQ(net.crossings().size(), 7U);
}

TEST(CorridorNet, ATourDrivesEachCorridorAndComesHome) {
  const CorridorNet net = two_loops();
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    const std::vector<std::size_t> tour = net.tour(200.0, random);
    EXPECT_EQ(tour.front(), 0U);
    EXPECT_EQ(tour.back(), 0U);
    const double length = length_of(net, tour);
    EXPECT_GE(length, 200.0);
    EXPECT_LE(length, 243.0);  // the last corridor, and home from anywhere: 10 m + 33 m
    std::set<std::pair<std::size_t, std::size_t>> driven;
    for (std::size_t i = 1; i < tour.size(); ++i) {
      driven.insert(std::minmax({tour[i - 1], tour[i]}));
    }
    EXPECT_EQ(driven.size(), 8U) << "seed " << seed;
  }
}

TEST(CorridorNet, ATourTurnsBackOnlyAtTheEndOfABlindAlley) {
  const CorridorNet net = two_loops();
  Random random(3);
  const std::vector<std::size_t> tour = net.tour(1000.0, random);
  double way = 0.0;
  for (std::size_t i = 2; i < tour.size() && way < 980.0; ++i) {
    way += (net.crossings()[tour[i]] - net.crossings()[tour[i - 1]]).norm();
    if (tour[i] == tour[i - 2]) {
      EXPECT_EQ(net.crossings()[tour[i - 1]].x(), 23.0);
    }
  }
}

}  // namespace
}  // namespace matchbox_slam
