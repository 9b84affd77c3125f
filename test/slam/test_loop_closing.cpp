// Loops in the graph of key scans whose true poses are known.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"
#include "simulation/simulation_support.hpp"
#include "slam/local_map.hpp"
#include "slam/loop_closing.hpp"
#include "slam/map_equality.hpp"
#include "slam/path_uncertainty.hpp"

namespace matchbox_slam {
namespace {

const LoopOptions kOptions = [] {
  LoopOptions options;
  options.drift_xy = 0.05;
  options.drift_theta = 0.004;
  return options;
}();

/// With which all key scans are kept.
EngineOptions engine_options(const LoopOptions& loops = kOptions) {
  EngineOptions options;
  options.slam.enough_views = 0;
  options.loops = loops;
  return options;
}

const Eigen::Matrix3d kMatch = Eigen::Vector3d(1e-6, 1e-6, 1e-7).asDiagonal();

/// What a robot saw from one place, and where it believed to be.
struct Sight {
  Pose2 world_from_base;
  Pose2 map_from_base;
  double stamp = 0.0;
  Eigen::Matrix3d covariance = kMatch;  ///< of where it believed to be
};

/// Takes the key scans one by one, and searches with each, until a loop is closed.
class Drive {
 public:
  explicit Drive(World world) : world_(std::move(world)) { laser_.beams = 180; }

  void take(const Sight& sight, const LoopOptions& options) {
    truth_.push_back(sight.world_from_base);
    keys_.add(MeasuredScan{ideal_scan(world_, laser_, sight.world_from_base, sight.stamp),
                           laser_.base_from_laser(),
                           {},
                           {}},
              0, sight.map_from_base);
    closer_.add(keys_, sight.covariance, true, options);
    believed_ = keys_.poses();
  }

  [[nodiscard]] std::optional<MapCorrection> search(const LoopOptions& options) {
    closer_.begin(keys_, {}, engine_options(options));
    return closer_.is_pending() ? closer_.finish(keys_).correction : std::nullopt;
  }

  [[nodiscard]] std::optional<MapCorrection> take_all(const std::vector<Sight>& sights,
                                                      const LoopOptions& options = kOptions) {
    for (const Sight& sight : sights) {
      take(sight, options);
      if (auto correction = search(options)) {
        return correction;
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] double worst_error(const std::vector<Pose2>& poses) const {  // [m]
    double worst = 0.0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      worst = std::max(worst, (poses[i].translation() - truth_[i].translation()).norm());
    }
    return worst;
  }

  [[nodiscard]] double newest_error() const {  // [m]
    return (keys_.all().back().map_from_base.translation() - truth_.back().translation()).norm();
  }

  /// Where the key scans are before the correction.
  [[nodiscard]] const std::vector<Pose2>& believed() const { return believed_; }
  [[nodiscard]] std::vector<Pose2> poses() const { return keys_.poses(); }

  [[nodiscard]] const Pose2& truth(std::size_t i) const { return truth_[i]; }
  [[nodiscard]] const LoopCloser& closer() const { return closer_; }
  [[nodiscard]] LoopCloser& closer() { return closer_; }
  [[nodiscard]] const KeyScans& keys() const { return keys_; }
  [[nodiscard]] KeyScans& keys() { return keys_; }

 private:
  World world_;
  LaserOptions laser_;
  KeyScans keys_;
  std::vector<Pose2> truth_;
  std::vector<Pose2> believed_;
  LoopCloser closer_;
};

// --- round a block ---

/// A lap of a corridor and 16 m more; halfway the robot slips by half a metre and 0.05 rad.
std::vector<Sight> lap_with_a_slip(const World& world, const Pose2& slip) {
  const RobotMotion motion = drive(world.route(), {});
  std::vector<Sight> sights;
  std::vector<Pose2> truth;
  for (double time = 0.0; time <= motion.duration(); time += 0.1) {
    const Pose2 pose = motion.pose(time);
    const Pose2 moved = truth.empty() ? pose : truth.back().inverse() * pose;
    if (truth.empty() || moved.translation().norm() >= 0.3 || std::abs(moved.theta) >= 0.2) {
      truth.push_back(pose);
    }
  }
  const std::size_t middle = truth.size() / 2;
  const Pose2 map_from_world = truth[middle] * slip * truth[middle].inverse();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    sights.push_back({truth[i], i < middle ? truth[i] : map_from_world * truth[i],
                      0.2 * static_cast<double>(i)});
  }
  return sights;
}

const Pose2 kSlip{0.4, -0.3, 0.05};

TEST(LoopClosing, RoundABlockTheDriftGoes) {
  const World world = make_loop_world(1);
  Drive drive(world);
  const auto correction = drive.take_all(lap_with_a_slip(world, kSlip));
  ASSERT_TRUE(correction);
  const ClosedLoop& loop = drive.closer().state().loops.back();
  const std::vector<Pose2> poses = drive.poses();
  EXPECT_TRUE(loop.is_inlier);
  EXPECT_EQ(loop.newest, poses.size() - 1);
  EXPECT_GT(drive.worst_error(drive.believed()), 1.1);
  const Eigen::Vector3d off = difference(
      loop.found.key_from_newest, drive.truth(loop.found.key).inverse() * drive.truth(loop.newest));
  EXPECT_LT(off.head<2>().norm(), 0.001);  // 0.03 mm
  EXPECT_LT(std::abs(off.z()), 0.0002);
  EXPECT_LT(drive.newest_error(), 0.01);
}

TEST(LoopClosing, ALoopThatFitsAlreadyMovesNothing) {
  const World world = make_loop_world(1);
  Drive drive(world);
  EXPECT_FALSE(drive.take_all(lap_with_a_slip(world, {})));
  ASSERT_FALSE(drive.closer().state().loops.empty());
  EXPECT_TRUE(drive.closer().state().loops.back().is_inlier);
  EXPECT_EQ(drive.poses(), drive.believed());
}

TEST(LoopClosing, DriftThatGrewOnTheWayGoesEverywhere) {
  const World world = make_loop_world(1);
  std::vector<Sight> sights = lap_with_a_slip(world, {});
  const Pose2 drift{0.001, 0.001, 0.0002};  // each step
  for (std::size_t i = 1; i < sights.size(); ++i) {
    const Pose2 moved = sights[i - 1].world_from_base.inverse() * sights[i].world_from_base;
    sights[i].map_from_base = sights[i - 1].map_from_base * moved * drift;
  }
  Drive drive(world);
  ASSERT_TRUE(drive.take_all(sights));
  EXPECT_GT(drive.worst_error(drive.believed()), 1.0);
  EXPECT_LT(drive.worst_error(drive.poses()), 0.2);  // 0.15 m, half a lap away
  EXPECT_LT(drive.newest_error(), 0.01);
}

/// A robot that drove away and is set down where it began.
class SetDownTest : public testing::Test {
 protected:
  void add(const Pose2& map_from_base) {
    keys_.add(MeasuredScan{ideal_scan(world_, laser_, map_from_base, stamp_ += 1.0),
                           laser_.base_from_laser(),
                           {},
                           {}},
              0, map_from_base);
  }

  World world_ = make_rooms_world(4);
  LaserOptions laser_;
  double stamp_ = 0.0;
  KeyScans keys_;
  LoopCloser closer_;
};

TEST_F(SetDownTest, WhatLiesWhereItWasFoundIsJoinedHoweverFarTheWayThere) {
  const auto edges_when = [this](bool is_continued) {
    keys_ = {};
    closer_ = {};
    for (int i = 0; i < 60; ++i) {
      add({1.0 + 0.3 * i, 1.0, 0.0});
      closer_.add(keys_, kMatch + Eigen::Matrix3d(0.1 * Eigen::Matrix3d::Identity()), true,
                  kOptions);
    }
    const std::size_t before = closer_.state().edges.size();
    add({1.0, 1.0, 0.0});
    closer_.add(keys_, kMatch, is_continued, kOptions);
    return closer_.state().edges.size() - before;
  };
  EXPECT_EQ(edges_when(true), 1U) << "hardly known where: a search has to find it";
  EXPECT_EQ(edges_when(false), 2U);
}

TEST_F(SetDownTest, TheWayThereIsHardlyKnownWhereThePlaceIs) {
  const auto variance_of_way_to = [this](const Pose2& place) {
    keys_ = {};
    closer_ = {};
    for (int i = 0; i < 10; ++i) {
      add({1.0 + 0.3 * i, 1.0, 0.0});
      closer_.add(keys_, kMatch, true, kOptions);
    }
    const std::size_t way = closer_.state().edges.size();
    add(place);
    closer_.add(keys_, kMatch, false, kOptions);
    return closer_.state().edges[way].covariance(0, 0);
  };
  EXPECT_GT(variance_of_way_to({1.6, 1.0, 0.0}), 1.0);
  EXPECT_LT(variance_of_way_to({9.0, 1.0, 0.0}), 0.1) << "nothing else holds it";
}

TEST_F(SetDownTest, AMapWithoutAGraphStaysAsItIs) {
  for (int i = 0; i < 5; ++i) {
    add({1.0 + 0.3 * i, 1.0, 0.0});
  }
  closer_.add(keys_, kMatch, false, kOptions);
  ASSERT_EQ(closer_.state().edges.size(), 5U) << "the newest matches an earlier one";
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT(closer_.state().edges[i].covariance.trace(), 1e-5) << i;
    EXPECT_TRUE(closer_.state().edges[i].drift.isZero()) << i;
  }
  EXPECT_GT(closer_.state().edges[3].covariance.trace(), 1e-3);
  // A way of 0.3 m.
  EXPECT_NEAR(closer_.state().edges[3].drift.x(), 0.3 * 0.05 * 0.05, 1e-12);
  EXPECT_NEAR(closer_.state().edges[3].drift.z(), 0.3 * 0.004 * 0.004, 1e-12);
}

/// A lap on a straight of which the wheels slip: where the robot seems to have driven 0.3 m in the
/// time for 0.9 it drove all of them.
/// @param sigma  [m], how well it is known how far.
std::vector<Sight> lap_with_slip_inflation(const World& world, double sigma) {
  constexpr std::ptrdiff_t kHidden = 2;
  std::vector<Sight> sights = lap_with_a_slip(world, {});
  const auto slow = sights.begin() + static_cast<std::ptrdiff_t>(3 * sights.size() / 8);
  const auto after = slow + kHidden;
  const Pose2 seen = std::prev(slow)->world_from_base * Pose2{0.3, 0.0, 0.0};
  const Pose2 map_from_world = seen * after->world_from_base.inverse();
  std::for_each(after, sights.end(), [&](Sight& sight) {
    sight.map_from_base = map_from_world * sight.world_from_base;
  });
  after->covariance = covariance_of(sigma, 1e-3);
  sights.erase(slow, after);
  return sights;
}

TEST(LoopClosing, WayThatSlippingWheelsHidIsPutRightWhereItWasHidden) {
  const World world = make_loop_world(1);
  LoopOptions options = kOptions;
  options.max_window = 1.0;  // the corridor is much the same for some metres
  Drive drive(world);
  ASSERT_TRUE(drive.take_all(lap_with_slip_inflation(world, 0.05), options));
  EXPECT_GT(drive.worst_error(drive.believed()), 0.55);
  EXPECT_LT(drive.worst_error(drive.poses()), 0.25);  // 0.19
  Drive seen(world);
  ASSERT_TRUE(seen.take_all(lap_with_slip_inflation(world, 0.001), options));
  EXPECT_GT(seen.worst_error(seen.poses()), 0.35) << "scans tell how far it drove";
}

/// Until work has taken effect that was begun with the key scan at the end of the slow way.
class HiddenBesideTest : public testing::Test {
 protected:
  HiddenBesideTest() {
    const auto slow = std::max_element(
        sights_.begin(), sights_.end(),
        [](const auto& a, const auto& b) { return a.covariance(0, 0) < b.covariance(0, 0); });
    std::for_each(sights_.begin(), slow + 1,
                  [&](const auto& sight) { drive_.take(sight, kOptions); });
    edge_ = drive_.closer().state().edges.size() - 1;
    drive_.closer().begin(drive_.keys(), near(), engine_options());
    drive_.take(slow[1], kOptions);
  }

  /// [m^2] of the way that was slow.
  [[nodiscard]] double variance(const LoopCloser& closer) const {
    return closer.state().edges[edge_].covariance.topLeftCorner<2, 2>().trace();
  }

  [[nodiscard]] LocalMapRequest near() const {
    return {local_scans(drive_.keys().all(), drive_.closer().ways(drive_.keys()),
                        kOptions.max_relative_sigma)};
  }

  const World world_ = make_loop_world(1);
  const std::vector<Sight> sights_ = lap_with_slip_inflation(world_, 0.05);
  Drive drive_{world_};
  std::size_t edge_ = 0;
};

TEST_F(HiddenBesideTest, TheGraphStaysAsItIsWhileWorkIsUnderWay) {
  EXPECT_LT(variance(drive_.closer()), 0.1 * 0.1);
  static_cast<void>(drive_.closer().finish(drive_.keys()));
  EXPECT_GT(variance(drive_.closer()), 0.3 * 0.3);
}

TEST_F(HiddenBesideTest, WorkThatIsAbandonedLeavesNothingOut) {
  drive_.closer().abandon();
  static_cast<void>(drive_.closer().finish(drive_.keys()));
  EXPECT_GT(variance(drive_.closer()), 0.3 * 0.3);
}

TEST_F(HiddenBesideTest, AMapThatIsGoneOnWithIsTheSame) {
  LoopCloser again(drive_.closer().state());
  KeyScans keys = drive_.keys();
  again.begin_again(keys, {}, engine_options());
  const LoopCloser::Result gone_on = again.finish(keys);
  const LoopCloser::Result never_stopped = drive_.closer().finish(drive_.keys());
  ASSERT_TRUE(gone_on.near && never_stopped.near);
  EXPECT_TRUE(same_map(*gone_on.near->map(), *never_stopped.near->map()));
  ASSERT_EQ(again.state().edges.size(), drive_.closer().state().edges.size());
  for (std::size_t i = 0; i < again.state().edges.size(); ++i) {
    EXPECT_EQ(again.state().edges[i].covariance, drive_.closer().state().edges[i].covariance) << i;
  }
}

TEST_F(HiddenBesideTest, AMapOfWhatLiesNearIsGoneOnWith) {
  static_cast<void>(drive_.closer().finish(drive_.keys()));
  LocalMapRequest request = near();
  LocalScans fewer = *request.scans;
  ASSERT_GT(fewer.belonging.size(), 5U);
  fewer.belonging.erase(fewer.belonging.end() - 5, fewer.belonging.end());
  request.before = LocalMap(fewer, {}, {});
  // What it shows stays, where a map that is made anew would not show it.
  PlacedScans& near_now = request.scans->belonging;
  near_now.erase(near_now.begin(), near_now.begin() + 2);
  drive_.closer().begin(drive_.keys(), request, engine_options());
  LoopCloser again(drive_.closer().state());
  KeyScans keys = drive_.keys();
  again.begin_again(keys, request.before, engine_options());
  const LoopCloser::Result gone_on = again.finish(keys);
  const LoopCloser::Result never_stopped = drive_.closer().finish(drive_.keys());
  ASSERT_TRUE(gone_on.near && never_stopped.near);
  const std::vector<std::uint64_t>& drawn = never_stopped.near->drawn();
  ASSERT_EQ(drawn.size(), request.before.drawn().size() + 5);
  EXPECT_TRUE(std::equal(request.before.drawn().begin(), request.before.drawn().end(),
                         drawn.begin(), drawn.end() - 5));
  EXPECT_EQ(gone_on.near->drawn(), drawn);
  EXPECT_TRUE(same_map(*gone_on.near->map(), *never_stopped.near->map()));
}

static_assert(!std::is_copy_constructible_v<LoopCloser>, "its work under way is its own");

TEST_F(HiddenBesideTest, IsDestroyedWithWorkUnderWay) {
  ASSERT_TRUE(drive_.closer().is_pending());
  const LoopState state = drive_.closer().state();
  drive_.closer() = LoopCloser(state);
  EXPECT_TRUE(drive_.closer().is_pending()) << "to be begun again";
}

TEST(LoopClosing, CorrectionsAreStepsInOrderOfTime) {
  const World world = make_loop_world(1);
  std::vector<Sight> sights = lap_with_a_slip(world, kSlip);
  for (std::size_t i = 0; i < sights.size(); ++i) {
    sights[i].stamp = 100.0 + static_cast<double>(i);
  }
  std::swap(sights[50].stamp, sights[60].stamp);  // as of what was mapped by a lost robot
  Drive drive(world);
  const auto correction = drive.take_all(sights);
  ASSERT_TRUE(correction);
  const std::vector<Pose2> before = drive.believed();
  ASSERT_EQ(correction->steps.size(), before.size());
  double most_moved = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const auto& step = correction->steps[i == 50 ? 60 : i == 60 ? 50 : i];
    EXPECT_EQ(step.since, sights[i].stamp);
    const Pose2& after = drive.keys().all()[i].map_from_base;
    EXPECT_LT(difference(step.new_from_old * before[i], after).norm(), 1e-9) << i;
    most_moved = std::max(most_moved, (after.translation() - before[i].translation()).norm());
    EXPECT_TRUE(i == 0 || correction->steps[i - 1].since < correction->steps[i].since) << i;
  }
  EXPECT_EQ(drive.closer().state().loops.back().moved, most_moved);
  EXPECT_LT(difference(correction->newest * before.back(), drive.poses().back()).norm(), 1e-9);
  EXPECT_EQ(drive.poses().front(), before.front()) << "the map begins where it did";
}

TEST(LoopClosing, WaitsForItsWayBeforeASearch) {
  const World world = make_loop_world(1);
  LoopOptions options = kOptions;
  options.least_score = 1.0;  // so that none is found, and the next is searched for
  Drive drive(world);
  std::size_t searches = 0;
  for (const Sight& sight : lap_with_a_slip(world, kSlip)) {  // 0.3 m apart
    drive.take(sight, options);
    const double way = drive.closer().state().way;
    drive.closer().begin(drive.keys(), {}, engine_options(options));
    EXPECT_TRUE(way >= 1.0 || !drive.closer().is_pending()) << way;
    if (drive.closer().is_pending()) {
      ++searches;
      EXPECT_EQ(drive.closer().state().way, 0.0);
      static_cast<void>(drive.closer().finish(drive.keys()));
    }
  }
  EXPECT_GT(searches, 5U);
}

// --- beside the mapping ---

class BesideTheMappingTest : public testing::Test {
 protected:
  /// Until a search is under way that will find the loop.
  void SetUp() override {
    ASSERT_TRUE(immediate_.take_all(sights_));
    found_with_ = immediate_.closer().state().loops.back().newest;
    for (next_ = 0; next_ <= found_with_; ++next_) {
      drive_.take(sights_[next_], kOptions);
      if (drive_.closer().is_due(drive_.keys())) {
        ASSERT_FALSE(drive_.closer().finish(drive_.keys()).correction);
      }
      drive_.closer().begin(drive_.keys(), {}, engine_options());
    }
    ASSERT_TRUE(drive_.closer().is_pending());
    begun_with_ = drive_.closer().state().pending->newest;
  }

  /// Until what is pending is due.
  void drive_on() {
    while (!drive_.closer().is_due(drive_.keys())) {
      drive_.take(sights_[next_++], kOptions);
    }
  }

  const World world_ = make_loop_world(1);
  const std::vector<Sight> sights_ = lap_with_a_slip(world_, kSlip);
  Drive immediate_{world_};
  Drive drive_{world_};
  std::size_t found_with_ = 0;
  std::size_t begun_with_ = 0;
  std::size_t next_ = 0;
};

TEST_F(BesideTheMappingTest, ALoopTakesEffectHalfAMetreOnAndWhatCameSinceMovesWithIt) {
  drive_on();
  EXPECT_EQ(drive_.keys().size(), begun_with_ + 3) << "of 0.3 m";
  const std::vector<Pose2> before = drive_.believed();
  const LoopCloser::Result result = drive_.closer().finish(drive_.keys());
  ASSERT_TRUE(result.correction && result.near);
  EXPECT_FALSE(drive_.closer().is_pending());
  const std::vector<Pose2> after = drive_.poses();
  ASSERT_EQ(after.size(), before.size());
  EXPECT_EQ(result.near->center(), after[begun_with_].translation());
  for (std::size_t i = begun_with_ + 1; i < after.size(); ++i) {
    const Pose2 seen_before = before[begun_with_].inverse() * before[i];
    EXPECT_LT(difference(after[begun_with_].inverse() * after[i], seen_before).norm(), 1e-9);
  }
  EXPECT_LT(drive_.newest_error(), 0.02);
  EXPECT_NO_THROW(require_sound(graph_of(drive_.keys(), drive_.closer().state())));
}

TEST_F(BesideTheMappingTest, WhatIsBegunAgainFromAStateFindsTheSame) {
  drive_.take(sights_[next_++], kOptions);
  LoopCloser again(drive_.closer().state());
  KeyScans keys = drive_.keys();
  again.begin_again(keys, {}, engine_options());
  EXPECT_TRUE(drive_.closer().finish(drive_.keys()).correction);
  EXPECT_TRUE(again.finish(keys).correction);
  EXPECT_EQ(keys.poses(), drive_.poses());
}

TEST_F(BesideTheMappingTest, WhatIsAbandonedChangesNothing) {
  drive_.closer().abandon();
  drive_on();
  const std::vector<Pose2> before = drive_.believed();
  EXPECT_FALSE(drive_.closer().finish(drive_.keys()).correction);
  EXPECT_EQ(count_closed(drive_.closer().state().loops), 0U);
  EXPECT_EQ(drive_.poses().back(), before.back());
  drive_.closer().begin(drive_.keys(), {LocalScans{}}, engine_options());
  EXPECT_TRUE(drive_.closer().is_pending()) << "the next may begin";
}

// --- places that look alike ---

void add_room(const Eigen::Vector2d& corner, bool is_mirrored, std::vector<WallSegment>& walls) {
  const auto wall = [&](double x0, double y0, double x1, double y1) {
    const double width = 2.6;
    const auto x = [&](double value) { return is_mirrored ? width - value : value; };
    walls.push_back({corner + Eigen::Vector2d(x(x0), y0), corner + Eigen::Vector2d(x(x1), y1)});
  };
  wall(0.0, 0.0, 2.6, 0.0);
  wall(2.6, 0.0, 2.6, 2.2);
  wall(2.6, 2.2, 1.7, 2.2);
  wall(1.7, 2.2, 1.7, 2.9);
  wall(1.7, 2.9, 0.0, 2.9);
  wall(0.0, 2.9, 0.0, 0.0);
}

constexpr double kPitch = 3.0;  // [m]

/// Three rooms in a row, the first two alike, the third one another.
World three_rooms() {
  std::vector<WallSegment> walls;
  add_room({0.0, 0.0}, false, walls);
  add_room({kPitch, 0.0}, false, walls);
  add_room({2.0 * kPitch, 0.0}, true, walls);
  return World(walls, {});
}

/// Ten places in a room, a long way outside, and ten in a room again.
/// @param map_from_world  where the robot believes itself at the end.
std::vector<Sight> from_room_to_room(double to_x, const Pose2& map_from_world) {
  std::vector<Sight> sights;
  const auto see = [&](double x, double y, bool at_end) {
    const Pose2 pose{x, y, 0.2};
    sights.push_back({pose, at_end ? map_from_world * pose : pose});
  };
  for (int i = 0; i < 10; ++i) {
    see(0.6 + 0.1 * i, 0.7 + 0.05 * i, false);
  }
  for (int i = 0; i < 60; ++i) {
    see(1.0 + 0.1 * i, 3.0 + 1.0 * std::abs(i % 12 - 6), false);
  }
  for (int i = 0; i < 10; ++i) {
    see(to_x + 0.6 + 0.1 * i, 0.7 + 0.05 * i, true);
  }
  return sights;
}

std::optional<MapCorrection> search_at_end(const std::vector<Sight>& sights, Drive& drive,
                                           const LoopOptions& options = kOptions) {
  for (const Sight& sight : sights) {
    drive.take(sight, options);
  }
  return drive.search(options);
}

/// Round in a room, 20 key scans each.
Drive seven_rounds() {
  Drive drive(three_rooms());
  for (int i = 0; i < 141; ++i) {
    const double angle = 2.0 * kPi * i / 20.0;
    const Pose2 pose{1.0 + 0.3 * std::cos(angle), 1.2 + 0.3 * std::sin(angle), 0.2};
    drive.take({pose, pose}, kOptions);
  }
  return drive;
}

TEST(LoopClosing, AKeyScanIsJoinedToEachVisit) {
  const Drive drive = seven_rounds();
  const auto joined_to = [&drive](std::size_t key) {
    std::vector<std::size_t> others;
    for (const PoseEdge& edge : drive.closer().state().edges) {
      if (edge.to == key) {
        others.push_back(edge.from);
      }
    }
    std::sort(others.begin(), others.end());
    return others;
  };
  EXPECT_EQ(joined_to(20), (std::vector<std::size_t>{19})) << "just now is no time before";
  EXPECT_EQ(joined_to(60), (std::vector<std::size_t>{0, 20, 59}));
  EXPECT_EQ(joined_to(140).size(), 1U + 4U) << "of six times, the nearest four";
}

TEST(LoopClosing, ToFourVisitsAKeyScanIsJoinedWithTheWeightOfOne) {
  const Drive drive = seven_rounds();
  const PoseGraph graph = graph_of(drive.keys(), drive.closer().state());
  const AdjacencyList links(graph);
  const PathUncertainty ways(graph, links, graph.poses.size() - 1);
  const auto joins_before = [&](std::size_t before) {
    return match_with_earlier(drive.keys().all(), before, ways, true, kOptions);
  };
  const std::vector<FoundLoop> one = joins_before(1);
  const std::vector<FoundLoop> four = joins_before(100);
  ASSERT_EQ(one.size(), 1U);
  ASSERT_EQ(four.size(), 4U);
  const auto same =
      std::find_if(four.begin(), four.end(), [](const FoundLoop& join) { return join.key == 0; });
  ASSERT_NE(same, four.end());
  EXPECT_TRUE(same->covariance.isApprox(4.0 * one.front().covariance, 1e-9));
}

TEST(LoopClosing, ARoomIsFoundAgain) {
  Drive drive(three_rooms());
  EXPECT_TRUE(search_at_end(from_room_to_room(0.0, {0.3, -0.2, 0.03}), drive));
  EXPECT_LT(drive.newest_error(), 0.02);
}

TEST(LoopClosing, AnEqualRoomOutOfOdometrysReachIsNotTakenForIt) {
  Drive drive(three_rooms());
  EXPECT_FALSE(search_at_end(from_room_to_room(kPitch, {}), drive));
  Drive unsure(three_rooms());
  LoopOptions options = kOptions;
  options.drift_xy = 0.5;
  EXPECT_TRUE(search_at_end(from_room_to_room(kPitch, {}), unsure, options))
      << "they are so alike that odometry alone can tell them apart";
}

TEST(LoopClosing, APlaceThatWasNotSeenIsNoLoop) {
  Drive drive(three_rooms());
  EXPECT_FALSE(search_at_end(from_room_to_room(2.0 * kPitch, {-2.0 * kPitch, 0.0, 0.0}), drive));
}

/// Ten places beside a wall, a long way elsewhere, and ten beside the wall again, 5 cm off.
std::vector<Sight> beside_a_wall(double first_y, double then_y) {
  std::vector<Sight> sights;
  const auto see = [&](double x, double y, double off = 0.0) {
    sights.push_back({{x, y, 0.2}, {x + off, y, 0.2}});
  };
  for (int i = 0; i < 10; ++i) {
    see(0.1 * i - 1.0, first_y);
  }
  for (int i = 0; i < 60; ++i) {
    see(1.0 + 0.1 * i, 12.0 + 1.0 * std::abs(i % 12 - 6));
  }
  for (int i = 0; i < 10; ++i) {
    see(0.1 * i - 1.0, then_y, 0.05);
  }
  return sights;
}

TEST(LoopClosing, AWallSeenFromItsOtherSideIsNotTakenForTheSame) {
  std::vector<WallSegment> walls;
  const std::vector<Eigen::Vector2d> corners = {{-5.0, 0.0}, {-2.0, 0.0}, {-2.0, 0.7}, {0.0, 0.7},
                                                {0.0, -0.4}, {2.5, -0.4}, {2.5, 0.2},  {5.0, 0.2}};
  for (std::size_t i = 1; i < corners.size(); ++i) {
    walls.push_back({corners[i - 1], corners[i]});
  }
  add_room({4.0, 11.0}, false, walls);
  const World world(walls, {});
  Drive same(world);
  EXPECT_TRUE(search_at_end(beside_a_wall(-1.2, -1.3), same));
  Drive other(world);
  EXPECT_FALSE(search_at_end(beside_a_wall(-1.2, 1.4), other));
}

}  // namespace
}  // namespace matchbox_slam
