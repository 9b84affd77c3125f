#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matching/rendered_map.hpp"
#include "slam/key_scans_of_rooms.hpp"
#include "slam/local_map.hpp"
#include "slam/map_equality.hpp"
#include "slam/mapping.hpp"

namespace matchbox_slam {
namespace {

class MappingTest : public testing::Test {
 protected:
  MappingTest() : mapping_(options_) {}

  bool insert(const PlacedScan& key) {
    return mapping_.insert(*key.scan->points(), key, covariance_of(0.01, 0.01));
  }
  /// The first key scans of a drive.
  void insert_first(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_TRUE(insert(keys_[i]));
    }
  }
  /// From what is saved.
  [[nodiscard]] Mapping gone_on(MapRenderer drawing, bool is_continued,
                                const std::vector<WaitingScan>& waiting = {}) const {
    return {MapComponents(mapping_.components().all(), 0, waiting),
            LoopCloser(mapping_.loops().state()),
            std::move(drawing),
            is_continued,
            true,
            options_};
  }
  /// From what is saved while a scan waits.
  void wait(const PlacedScan& scan) { mapping_ = gone_on(mapping_.renderer(), true, {{0, scan}}); }
  /// From what is saved while only what lies near is matched against.
  [[nodiscard]] Mapping gone_on_with_local_map(const std::vector<WaitingScan>& waiting = {}) const {
    const PlacedScans& all = mapping_.components().map().key_scans.all();
    LocalMap near(local_scans_where(all, std::vector<bool>(all.size(), false)), options_.map,
                  options_.field);
    return gone_on({std::move(near), true, all.size()}, true, waiting);
  }
  [[nodiscard]] std::size_t mapped() const { return mapping_.components().map().key_scans.size(); }

  EngineOptions options_;
  const PlacedScans keys_ = drive_through_rooms(6);
  Mapping mapping_;
};

TEST_F(MappingTest, MakesScansKeyScansOfMapAndGraph) {
  insert_first(3);
  EXPECT_EQ(mapped(), 3U);
  EXPECT_EQ(mapping_.loops().state().nodes, 3U);
  EXPECT_EQ(mapping_.components().map().last_inserted.at(0), keys_[2].map_from_base);
  EXPECT_TRUE(same_map(mapping_.matched(), rendered({keys_[0], keys_[1], keys_[2]}, options_.map,
                                                    options_.field, MapUse::kShown)));
}

TEST_F(MappingTest, LeavesOutWhatTheMapHasNoRoomFor) {
  insert_first(1);
  EXPECT_FALSE(insert({keys_[1].scan, {1e7, 0.0, 0.0}}));
  EXPECT_EQ(mapped(), 1U);
  EXPECT_EQ(mapping_.components().map().last_inserted.at(0), keys_[0].map_from_base);
}

TEST_F(MappingTest, IsNotContinuedByWhatItLeavesOut) {
  insert_first(1);
  Mapping from_elsewhere = gone_on({{}, false, 1}, false);
  const PlacedScan too_far{keys_[1].scan, {1e7, 0.0, 0.0}};
  const Eigen::Matrix3d covariance = covariance_of(0.01, 0.01);
  EXPECT_FALSE(from_elsewhere.insert(*too_far.scan->points(), too_far, covariance));
  EXPECT_FALSE(from_elsewhere.is_continued());
  EXPECT_TRUE(from_elsewhere.insert(*keys_[1].scan->points(), keys_[1], covariance));
  EXPECT_TRUE(from_elsewhere.is_continued());
}

TEST_F(MappingTest, FinishesNoLoopsWhileTheRobotMayBeElsewhere) {
  insert_first(6);
  Mapping moved = gone_on({{}, true, 6}, true);
  static_cast<void>(moved.close_loops());
  ASSERT_TRUE(moved.loops().is_pending());
  moved.fork();
  EXPECT_FALSE(moved.finish_loops());
  EXPECT_TRUE(moved.loops().is_pending());
  moved.unfork();
  static_cast<void>(moved.finish_loops());
  EXPECT_FALSE(moved.loops().is_pending());
}

TEST_F(MappingTest, ShowsNothingSinceTheForkWhereItIsGoneOnWithAndThatIsForgotten) {
  insert_first(3);
  Mapping near_by = gone_on_with_local_map();
  near_by.fork_as_of(2, {});
  near_by.forget_since_fork();
  EXPECT_EQ(near_by.components().map().key_scans.size(), 2U);
  EXPECT_TRUE(same_map(near_by.whole(), rendered({keys_[0], keys_[1]}, options_.map, options_.field,
                                                 MapUse::kShown)));
}

TEST_F(MappingTest, KeepsTheMapAsItIsWhereALostRobotMayBeElsewhere) {
  insert_first(3);
  static_cast<void>(mapping_.begin_component(3.0));
  ASSERT_TRUE(insert(keys_[3]));
  ASSERT_TRUE(insert(keys_[4]));
  mapping_.fork_as_of(1, {});
  mapping_.forget_since_fork();
  EXPECT_EQ(mapping_.components().active().key_scans.size(), 1U);
  EXPECT_TRUE(same_map(mapping_.matched(),
                       rendered({keys_[3]}, options_.map, options_.field, MapUse::kShown)));
  EXPECT_TRUE(same_map(mapping_.drawn(), rendered({keys_[0], keys_[1], keys_[2]}, options_.map,
                                                  options_.field, MapUse::kShown)));
}

TEST_F(MappingTest, KeepsWallsThatCameWithoutKeyScans) {
  const SlamMap walls =
      rendered({keys_[0], keys_[1]}, options_.map, options_.field, MapUse::kShown);
  Mapping of_image{
      MapComponents({{walls, {}, {}, 0.0}}, 0, {}), {}, {{}, false, 0}, false, false, options_};
  of_image.fork_as_of(0, {});
  EXPECT_TRUE(same_map(of_image.compared(), walls));
  of_image.forget_since_fork();
  EXPECT_TRUE(same_map(of_image.drawn(), walls));
}

TEST_F(MappingTest, MapsALostRobotIntoAComponentAndPutsThatWhereItBelongs) {
  insert_first(3);
  const Mapping::BegunComponent begun = mapping_.begin_component(3.0);
  EXPECT_FALSE(begun.gave_up_component);
  EXPECT_TRUE(mapping_.is_lost());
  const Pose2 component_from_map{1.0, -2.0, 0.5};
  ASSERT_TRUE(insert({keys_[3].scan, component_from_map * keys_[3].map_from_base}));
  EXPECT_EQ(mapped(), 3U);
  EXPECT_EQ(mapping_.components().active().key_scans.size(), 1U);
  EXPECT_EQ(mapping_.loops().state().nodes, 3U);

  mapping_.join(0, component_from_map.inverse());
  EXPECT_FALSE(mapping_.is_lost());
  EXPECT_TRUE(mapping_.has_pending());
  EXPECT_EQ(mapping_.insert_pending(), 0U);
  EXPECT_FALSE(mapping_.has_pending());
  ASSERT_EQ(mapped(), 4U);
  const Eigen::Vector3d off = difference(
      mapping_.components().map().key_scans.all().back().map_from_base, keys_[3].map_from_base);
  EXPECT_LT(off.head<2>().norm(), 0.02);
  EXPECT_LT(std::abs(off.z()), 0.01);
}

TEST_F(MappingTest, DropsWhatWaitedAndWouldSeeThroughWalls) {
  insert_first(5);
  const Pose2& seen_from = keys_[0].map_from_base;
  wait({keys_[0].scan, {seen_from.x, seen_from.y, seen_from.theta + 0.8}});
  EXPECT_EQ(mapping_.insert_pending(), 0U);
  EXPECT_FALSE(mapping_.has_pending());
  EXPECT_EQ(mapped(), 5U);
}

/// A scan of what stands in a room that is mapped, as seen by a robot that is somewhere else: no
/// beam goes through a wall.
TEST_F(MappingTest, DropsWhatWaitedAndDoesNotFitWhatIsMapped) {
  insert_first(5);
  MeasuredScan close_by = *keys_[2].scan->measured();
  for (float& range : close_by.scan.ranges) {
    range *= 0.7F;
  }
  wait({std::make_shared<const KeyScan>(close_by, 0, 0), keys_[2].map_from_base});
  EXPECT_EQ(mapping_.insert_pending(), 0U);
  EXPECT_FALSE(mapping_.has_pending());
  EXPECT_EQ(mapped(), 5U);
}

TEST_F(MappingTest, KeepsWhatWaitsWhileTheMapIsNotToGrow) {
  insert_first(2);
  wait(keys_[2]);
  options_.slam.update_map = false;
  mapping_.set_options(options_);
  EXPECT_EQ(mapping_.insert_pending(), 0U);
  EXPECT_EQ(mapped(), 2U);
  options_.slam.update_map = true;
  mapping_.set_options(options_);
  EXPECT_EQ(mapping_.insert_pending(), 0U);
  EXPECT_EQ(mapped(), 3U);
}

TEST_F(MappingTest, IsDrawnOverWhileItIsNotToChangeAndStaysAsItIs) {
  insert_first(2);
  const SlamMap before = mapping_.components().map().map;
  options_.slam.update_map = false;
  mapping_.set_options(options_);
  const auto draw_over = [this] {
    mapping_.draw_over(*keys_[2].scan->points(), 0, keys_[2].map_from_base);
    return same_map(mapping_.matched(), rendered({keys_[0], keys_[1], keys_[2]}, options_.map,
                                                 options_.field, MapUse::kShown));
  };
  EXPECT_TRUE(draw_over());
  EXPECT_EQ(mapping_.temporary().last_drawn().at(0), keys_[2].map_from_base);
  EXPECT_EQ(mapping_.components().map().last_inserted.at(0), keys_[1].map_from_base);
  EXPECT_EQ(mapped(), 2U);
  EXPECT_TRUE(same_map(mapping_.lasting(), before));
  EXPECT_TRUE(same_map(mapping_.components().map().map, before));
  EXPECT_TRUE(same_map(mapping_.drawn(), before));
  // Scans are compared in what was known when the robot came into doubt.
  mapping_.fork();
  EXPECT_TRUE(same_map(mapping_.compared(), mapping_.matched()));
  static_cast<void>(mapping_.move_since_fork({}, {}, 3.0));
  EXPECT_TRUE(same_map(mapping_.matched(), before)) << "another pose has taken over";
  mapping_.unfork();
  EXPECT_TRUE(draw_over());
  mapping_.fork();
  mapping_.forget_since_fork();
  EXPECT_TRUE(same_map(mapping_.matched(), before));
  mapping_.unfork();
  EXPECT_TRUE(draw_over());
  static_cast<void>(mapping_.begin_component(3.0));
  mapping_.go_to_map();
  EXPECT_TRUE(same_map(mapping_.matched(), before)) << "a lost robot has forgotten";
  EXPECT_TRUE(mapping_.temporary().last_drawn().empty());
  EXPECT_TRUE(draw_over());
  options_.slam.update_map = true;
  mapping_.set_options(options_);
  EXPECT_TRUE(same_map(mapping_.matched(), before)) << "the map is to change";
  mapping_.draw_over(*keys_[2].scan->points(), 0, {1e7, 0.0, 0.0});
  EXPECT_EQ(mapping_.temporary().map(), nullptr) << "there is no room";
}

TEST_F(MappingTest, MatchesTheWholeMapWhileItIsNotToChange) {
  insert_first(3);
  Mapping mapping = gone_on_with_local_map();
  EXPECT_NE(mapping.renderer().local_map().map(), nullptr);
  options_.slam.update_map = false;  // so that no other local map is made
  EXPECT_EQ(gone_on_with_local_map().renderer().local_map().map(), nullptr);
  mapping.set_options(options_);
  EXPECT_EQ(mapping.renderer().local_map().map(), nullptr);
}

TEST_F(MappingTest, DrawsWhatWaitedIntoWhatLiesNearAtOnce) {
  insert_first(2);
  Mapping near_by = gone_on_with_local_map({{0, keys_[2]}});
  EXPECT_EQ(near_by.insert_pending(), 0U);
  const PlacedScans& all = near_by.components().map().key_scans.all();
  ASSERT_EQ(all.size(), 3U);
  EXPECT_TRUE(
      same_map(near_by.matched(), rendered(all, options_.map, options_.field, MapUse::kMatched)));
}

TEST_F(MappingTest, MatchesTheWholeMapWhereItIsGoneOnWithWithoutLoops) {
  insert_first(2);
  EXPECT_NE(gone_on_with_local_map().renderer().local_map().map(), nullptr);
  options_.slam.loop_closing = false;
  Mapping gone_on = gone_on_with_local_map();
  EXPECT_EQ(gone_on.renderer().local_map().map(), nullptr);
  ASSERT_TRUE(gone_on.insert(*keys_[2].scan->points(), keys_[2], covariance_of(0.01, 0.01)));
  EXPECT_TRUE(same_map(gone_on.matched(), rendered({keys_[0], keys_[1], keys_[2]}, options_.map,
                                                   options_.field, MapUse::kShown)));
}

}  // namespace
}  // namespace matchbox_slam
