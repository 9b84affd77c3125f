#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "matchbox_slam/slam/key_scans.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"
#include "simulation/simulation_support.hpp"
#include "slam/loop_search.hpp"

namespace matchbox_slam {
namespace {

// --- where to search ---

/// Key scans of nothing at these places of a line.
PlacedScans keys_at(const std::vector<double>& places, const Pose2& map_from_line = {}) {
  KeyScans keys;
  for (const double x : places) {
    keys.add(PointScan{}, 0, map_from_line * Pose2{x, 0.0, 0.0});
  }
  return keys.all();
}

/// A robot that goes away from where it begins, each step so long [m], and is back there.
std::vector<double> there_and_back(std::size_t there, double step) {
  std::vector<double> places;
  for (std::size_t i = 0; i < there; ++i) {
    places.push_back(step * static_cast<double>(i));
  }
  places.push_back(0.0);
  return places;
}

using Numbers = std::vector<std::size_t>;

/// Each one is joined to the newest, by a long way where it is to lie apart, and known that well.
Numbers candidates(const PlacedScans& keys, const std::vector<bool>& is_apart,
                   const std::vector<double>& variances, LoopOptions options) {
  constexpr double kLittle = 1e-8;  // [m^2]
  options.max_relative_sigma = std::sqrt(0.5 * kLittle);
  PoseGraph graph;
  for (std::size_t key = 0; key < keys.size(); ++key) {
    graph.poses.push_back(keys[key].map_from_base);
    if (key + 1 < keys.size()) {
      const double variance = std::max(variances[key], kLittle);
      graph.edges.push_back({key,
                             keys.size() - 1,
                             {is_apart[key] ? 100.0 : 1.0, 0.0, 0.0},
                             Eigen::Vector3d(variance, variance, 0.0).asDiagonal()});
    }
  }
  const AdjacencyList links(graph);
  Numbers numbers;
  for (const LoopCandidate& one : loop_candidates(keys, {graph, links, keys.size() - 1}, options)) {
    numbers.push_back(one.key);
  }
  return numbers;
}

TEST(NearestOfEachTime, AreTheNearestAndSoManyAtMost) {
  const std::vector<std::pair<double, std::size_t>> near{
      {0.4, 10}, {0.3, 14}, {0.9, 19}, {0.2, 40}, {0.8, 60}};
  EXPECT_EQ(nearest_of_each_visit(near, 5, 9), (std::vector<std::size_t>{40, 14, 60, 19}));
  EXPECT_EQ(nearest_of_each_visit(near, 6, 9), (std::vector<std::size_t>{40, 14, 60}));
  EXPECT_EQ(nearest_of_each_visit(near, 5, 2), (std::vector<std::size_t>{40, 14}));
  EXPECT_TRUE(nearest_of_each_visit({}, 5, 2).empty());
}

TEST(LoopCandidates, AreTheNearestOfThoseThatAreApart) {
  const std::vector<double> places = there_and_back(10, 0.3);
  std::vector<bool> is_apart(11, true);
  is_apart[10] = false;
  const std::vector<double> variances(11, 0.0);
  const LoopOptions options;
  EXPECT_EQ(candidates(keys_at(places), is_apart, variances, options), (Numbers{0}));
  is_apart[0] = is_apart[1] = false;
  EXPECT_EQ(candidates(keys_at(places), is_apart, variances, options), (Numbers{2}));
  is_apart.assign(11, false);
  EXPECT_EQ(candidates(keys_at(places), is_apart, variances, options), (Numbers{}));
}

TEST(LoopCandidates, ComeNearestFirst) {
  std::vector<double> places = there_and_back(50, -0.03);
  places.back() = -0.9;  // beside the one of number 30
  std::vector<bool> is_apart(51, true);
  is_apart[50] = false;
  const std::vector<double> variances(51, 0.0);
  EXPECT_EQ(candidates(keys_at(places), is_apart, variances, {}), (Numbers{30, 10}));
}

TEST(LoopCandidates, AreTwoThatWereNotTakenAfterEachOther) {
  const std::vector<double> places = there_and_back(100, 0.01);
  std::vector<bool> is_apart(101, true);
  is_apart[100] = false;
  const std::vector<double> variances(101, 0.0);
  EXPECT_EQ(candidates(keys_at(places), is_apart, variances, {}), (Numbers{0, 20}));
  is_apart[20] = false;
  EXPECT_EQ(candidates(keys_at(places), is_apart, variances, {}), (Numbers{0, 21}));
}

/// Up to 2 m and three standard deviations away, and no farther than a search reaches.
TEST(LoopCandidates, AreWhereTheNewestMayHaveBeenTaken) {
  const auto is_candidate = [](double distance, double sigma) {
    return !candidates(keys_at({distance, 0.0}), {true, false}, {sigma * sigma, 0.0}, {}).empty();
  };
  EXPECT_TRUE(is_candidate(1.99, 0.0));
  EXPECT_FALSE(is_candidate(2.01, 0.0));
  EXPECT_TRUE(is_candidate(-4.99, 1.0));
  EXPECT_FALSE(is_candidate(-5.01, 1.0));
  EXPECT_TRUE(is_candidate(9.99, 50.0));
  EXPECT_FALSE(is_candidate(10.01, 50.0));
}

TEST(LoopCandidates, DoNotDependOnTheMapsFrame) {
  const std::vector<double> places = there_and_back(70, 0.05);
  std::vector<bool> is_apart(71, true);
  is_apart[70] = is_apart[0] = false;
  const std::vector<double> variances(71, 0.1);
  const Numbers here = candidates(keys_at(places), is_apart, variances, {});
  EXPECT_EQ(here, (Numbers{1, 21}));
  EXPECT_EQ(candidates(keys_at(places, {-31.0, 12.0, 2.1}), is_apart, variances, {}), here);
}

// --- the search ---

/// What a robot saw on its way; by its map it drove the same way as seen from elsewhere since a
/// place of the way.
class DriftedDrive {
 public:
  DriftedDrive(World world, const LaserOptions& laser) : world_(std::move(world)), laser_(laser) {}

  void see(const Pose2& world_from_base, const Pose2& map_from_world = {}) {
    truth_.push_back(world_from_base);
    keys_.add(
        MeasuredScan{ideal_scan(world_, laser_, world_from_base), laser_.base_from_laser(), {}, {}},
        0, map_from_world * world_from_base);
  }

  [[nodiscard]] const PlacedScans& keys() const { return keys_.all(); }
  [[nodiscard]] Pose2 key_from_newest(std::size_t key) const {
    return truth_[key].inverse() * truth_.back();
  }
  [[nodiscard]] std::size_t size() const { return truth_.size(); }

 private:
  World world_;
  LaserOptions laser_;
  KeyScans keys_;
  std::vector<Pose2> truth_;
};

constexpr std::size_t kThere = 25;     // key scans of the first visit
constexpr std::size_t kCandidate = 7;  // of them, beside the newest of the second
constexpr std::size_t kMerged = 8;     // key scans that are searched at once

/// Through rooms, and once more, a little beside, with a map that has drifted by so much since, as
/// seen from the last place.
DriftedDrive twice_through_rooms(const Pose2& drift, const Pose2& map_from_world = {}) {
  LaserOptions laser;
  laser.beams = 180;
  const World world = make_rooms_world(3);
  const RobotMotion motion = drive(world.route(), {});
  DriftedDrive driven(world, laser);
  for (std::size_t i = 0; i < kThere; ++i) {
    driven.see(motion.pose(4.0 + 0.6 * static_cast<double>(i)), map_from_world);
  }
  const auto beside = [&](std::size_t i) {
    return motion.pose(4.3 + 0.6 * static_cast<double>(i)) * Pose2{0.0, 0.1, 0.05};
  };
  for (std::size_t i = 0; i < kMerged; ++i) {
    const Pose2 last = beside(kMerged - 1);
    driven.see(beside(i), map_from_world * last * drift * last.inverse());
  }
  return driven;
}

void expect_true(const std::optional<FoundLoop>& found, const DriftedDrive& driven,
                 std::size_t candidate) {
  ASSERT_TRUE(found);
  EXPECT_EQ(found->key, candidate);
  const Eigen::Vector3d off = difference(found->key_from_newest, driven.key_from_newest(candidate));
  EXPECT_LT(off.head<2>().norm(), 0.002);
  EXPECT_LT(std::abs(off.z()), 0.0005);
  EXPECT_GE(found->covariance(0, 0), 0.03 * 0.03);
  EXPECT_GE(found->covariance(2, 2), 0.005 * 0.005);
}

const Pose2 kDrift{0.6, -0.5, 0.1};

TEST(FindLoop, TellsWhereTheNewestWasTakenHoweverTheMapDrifted) {
  for (const Pose2& drift : {Pose2{}, kDrift, Pose2{-0.7, 0.4, -0.2}}) {
    const DriftedDrive driven = twice_through_rooms(drift);
    expect_true(find_loop(driven.keys(), {kCandidate, 0.5}, {}), driven, kCandidate);
  }
}

TEST(FindLoop, DoesNotDependOnTheMapsFrame) {
  const DriftedDrive here = twice_through_rooms(kDrift);
  const DriftedDrive there = twice_through_rooms(kDrift, {-51.0, 33.0, -2.2});
  const auto found = find_loop(here.keys(), {kCandidate, 0.5}, {});
  const auto elsewhere = find_loop(there.keys(), {kCandidate, 0.5}, {});
  ASSERT_TRUE(found && elsewhere);
  const Eigen::Vector3d off = difference(found->key_from_newest, elsewhere->key_from_newest);
  EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_NEAR(found->score, elsewhere->score, 1e-6);
}

/// Three standard deviations, and a metre where that is less.
TEST(FindLoop, SearchesAsFarAsItMayHaveDrifted) {
  const DriftedDrive driven = twice_through_rooms({2.0, 0.0, 0.0});
  EXPECT_FALSE(find_loop(driven.keys(), {kCandidate, 0.5}, {}));
  expect_true(find_loop(driven.keys(), {kCandidate, 1.0}, {}), driven, kCandidate);
  EXPECT_FALSE(find_loop(driven.keys(), {kCandidate, 0.8}, {})) << "hardly ever so far off";
  LoopOptions options;
  options.max_window = 1.5;
  EXPECT_FALSE(find_loop(driven.keys(), {kCandidate, 1.0}, options));
}

TEST(FindLoop, WhatFitsTooLittleIsNone) {
  const DriftedDrive driven = twice_through_rooms(kDrift);
  LoopOptions options;
  const auto found = find_loop(driven.keys(), {kCandidate, 0.5}, options);
  ASSERT_TRUE(found);
  options.least_score = found->score + 0.001;
  EXPECT_FALSE(find_loop(driven.keys(), {kCandidate, 0.5}, options));
  options.least_score = found->score - 0.001;
  EXPECT_TRUE(find_loop(driven.keys(), {kCandidate, 0.5}, options));
  options.most_rival = found->rival_share - 0.001;
  EXPECT_FALSE(find_loop(driven.keys(), {kCandidate, 0.5}, options)) << "another fits as well";
  options = {};
  options.decisive = found->log_odds + 0.001;
  EXPECT_FALSE(find_loop(driven.keys(), {kCandidate, 0.5}, options))
      << "too few scans speak for it";
  options.decisive = found->log_odds - 0.001;
  EXPECT_TRUE(find_loop(driven.keys(), {kCandidate, 0.5}, options));
}

/// The walls of a block of 3 m by 2 m; a robot drives round it.
DriftedDrive round_a_block() {
  const std::vector<WallSegment> block{{{-1.5, -1.0}, {1.5, -1.0}},
                                       {{1.5, -1.0}, {1.5, 1.0}},
                                       {{1.5, 1.0}, {-1.5, 1.0}},
                                       {{-1.5, 1.0}, {-1.5, -1.0}}};
  LaserOptions laser;
  laser.beams = 360;
  laser.field_of_view = 2.0 * kPi;
  laser.mount_x = 0.0;
  DriftedDrive driven(World(block, {}), laser);
  for (int i = 0; i < 21; ++i) {
    const double angle = 2.0 * kPi * i / 21.0;
    driven.see({4.0 * std::cos(angle), 4.0 * std::sin(angle), wrap_angle(angle + 0.5 * kPi)});
  }
  return driven;
}

/// Its walls are those of a closet, seen from the other side.
TEST(FindLoop, TheInsideOfWallsIsNotTheirOutside) {
  DriftedDrive closet = round_a_block();
  for (std::size_t i = 0; i < kMerged; ++i) {
    closet.see({0.4 - 0.1 * static_cast<double>(i), 0.1, 0.3});
  }
  EXPECT_FALSE(find_loop(closet.keys(), {10, 0.3}, {}));
  LoopOptions options;
  options.decisive = -100.0;
  EXPECT_FALSE(find_loop(closet.keys(), {10, 0.3}, options)) << "whatever its scans say";

  DriftedDrive block = round_a_block();
  for (std::size_t i = 0; i < kMerged; ++i) {
    block.see({-3.4 + 0.3 * static_cast<double>(i), 2.5, -0.7});
  }
  expect_true(find_loop(block.keys(), {10, 0.3}, {}), block, 10);
}

/// Whose ends are out of sight.
TEST(FindLoop, InACorridorThereIsNone) {
  const std::vector<WallSegment> walls{{{-200.0, -1.0}, {200.0, -1.0}},
                                       {{-200.0, 1.0}, {200.0, 1.0}}};
  LaserOptions laser;
  laser.beams = 180;
  laser.range_max = 8.0;
  DriftedDrive driven(World(walls, {}), laser);
  for (int i = 0; i < 12; ++i) {
    driven.see({0.5 * i, 0.0, 0.0});
  }
  driven.see({3.0, 0.2, 0.1});
  LoopOptions options;
  options.most_rival = 1.0;
  EXPECT_FALSE(find_loop(driven.keys(), {6, 0.3}, options));
}

// --- one against one ---

TEST(FindNear, TellsInDetailHowTheyLie) {
  const DriftedDrive driven = twice_through_rooms({0.05, -0.04, 0.02});
  const auto found = find_near(driven.keys(), kCandidate);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->key, kCandidate);
  const Eigen::Vector3d off =
      difference(found->key_from_newest, driven.key_from_newest(kCandidate));
  EXPECT_LT(off.head<2>().norm(), 0.005);
  EXPECT_LT(std::abs(off.z()), 0.002);
  EXPECT_GE(found->covariance(0, 0), 0.01 * 0.01);
  EXPECT_EQ(found->rival_share, 0.0);
}

TEST(FindNear, DoesNotDependOnTheMapsFrame) {
  const Pose2 drift{0.05, -0.04, 0.02};
  const auto found = find_near(twice_through_rooms(drift).keys(), kCandidate);
  const auto elsewhere =
      find_near(twice_through_rooms(drift, {80.0, -7.0, 1.9}).keys(), kCandidate);
  ASSERT_TRUE(found && elsewhere);
  const Eigen::Vector3d off = difference(found->key_from_newest, elsewhere->key_from_newest);
  EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-6);
}

TEST(FindNear, WhatIsNotWhereItIsKnownToBeIsNone) {
  EXPECT_FALSE(find_near(twice_through_rooms({0.15, 0.0, 0.0}).keys(), kCandidate))
      << "found 0.15 m away";
  EXPECT_FALSE(find_near(twice_through_rooms({0.0, 0.0, 0.08}).keys(), kCandidate)) << "and turned";
  const DriftedDrive driven = twice_through_rooms({});
  PlacedScans keys = driven.keys();
  keys[kCandidate].map_from_base = keys[kCandidate].map_from_base * Pose2{3.0, 2.0, 1.0};
  EXPECT_FALSE(find_near(keys, kCandidate)) << "it does not fit there";
}

}  // namespace
}  // namespace matchbox_slam
