#include <gtest/gtest.h>

#include "matchbox_slam/map/map_image.hpp"
#include "matching/rendered_map.hpp"
#include "slam/key_scans_of_rooms.hpp"
#include "slam/local_map.hpp"
#include "slam/map_equality.hpp"
#include "slam/map_renderer.hpp"

namespace matchbox_slam {
namespace {

const EngineOptions kDefaults;

MapComponent empty_component() { return {SlamMap(kDefaults.map, kDefaults.field), {}, {}}; }

void add(const PlacedScan& key, MapComponent& component, MapRenderer& drawing) {
  drawing.add(key, *key.scan->points(), component, kDefaults);
  drawing.catch_up(component, kDefaults);
}

SlamMap rendered_all(const MapComponent& component) {
  return rendered(component.key_scans.all(), kDefaults.map, kDefaults.field, MapUse::kShown);
}

/// Moves a key scan by a metre.
void move_first(MapComponent& component, MapRenderer& drawing) {
  drawing.expect_move();
  const Pose2 before = component.key_scans.all().front().map_from_base;
  component.key_scans.move(0, {before.x + 1.0, before.y, before.theta});
}

class MapRendererTest : public testing::Test {
 protected:
  void SetUp() override {
    for (std::size_t i = 0; i < 4; ++i) {
      add(keys_[i], component_, renderer_);
    }
  }

  const PlacedScans keys_ = drive_through_rooms(6, 1000);  // more than a map to match is drawn by
  MapComponent component_ = empty_component();
  MapRenderer renderer_;
};

TEST_F(MapRendererTest, DrawsEachKeyScanWhileTheWholeIsMatchedAgainst) {
  EXPECT_EQ(&renderer_.matched(component_), &component_.map);
  EXPECT_TRUE(same_map(component_.map, rendered_all(component_)));
}

TEST_F(MapRendererTest, DrawsTheWholeWhenAskedWhileWhatLiesNearIsMatchedAgainst) {
  const PlacedScans& all = component_.key_scans.all();
  renderer_.match_locally(
      {local_scans_where(all, {true, true, false, false}), kDefaults.map, kDefaults.field});
  const SlamMap before = component_.map;
  add(keys_[4], component_, renderer_);
  EXPECT_TRUE(same_map(component_.map, before));
  const auto near = [this](MapUse use) {
    return rendered({keys_[2], keys_[3], keys_[4]}, kDefaults.map, kDefaults.field, use);
  };
  EXPECT_TRUE(same_map(renderer_.matched(component_), near(MapUse::kMatched)));
  EXPECT_FALSE(same_map(near(MapUse::kMatched), near(MapUse::kShown)));
  EXPECT_TRUE(same_map(renderer_.whole(component_, kDefaults), rendered_all(component_)));
  renderer_.match_whole(component_, kDefaults);
  add(keys_[5], component_, renderer_);
  EXPECT_TRUE(same_map(renderer_.matched(component_), rendered_all(component_)));
}

TEST_F(MapRendererTest, DrawsAnewWhatHasMoved) {
  move_first(component_, renderer_);
  EXPECT_TRUE(renderer_.is_outdated());
  EXPECT_TRUE(renderer_.is_moved());
  EXPECT_TRUE(same_map(renderer_.whole(component_, kDefaults), rendered_all(component_)));
  EXPECT_FALSE(renderer_.is_outdated());
}

TEST_F(MapRendererTest, DrawsBesideWhatNobodyAsksForAtOnce) {
  EXPECT_FALSE(renderer_.begin_whole(component_, kDefaults)) << "it is all drawn";
  move_first(component_, renderer_);
  EXPECT_TRUE(renderer_.begin_whole(component_, kDefaults));
  EXPECT_FALSE(renderer_.is_moved());
  EXPECT_TRUE(same_map(renderer_.whole(component_, kDefaults), rendered_all(component_)));
  EXPECT_FALSE(renderer_.is_outdated());

  move_first(component_, renderer_);
  renderer_.begin_whole(component_, kDefaults);
  move_first(component_, renderer_);  // meanwhile
  EXPECT_TRUE(same_map(renderer_.whole(component_, kDefaults), rendered_all(component_)));
}

TEST_F(MapRendererTest, WhatIsDrawnToBeLookedAtIsRenderedBeforeItIsMatchedAgainst) {
  const auto draw = [this] {
    move_first(component_, renderer_);
    const SlamMap& drawn = renderer_.drawn(component_, kDefaults);
    const SlamMap expected = rendered_all(component_);
    EXPECT_FALSE(renderer_.is_outdated());
    EXPECT_FALSE(drawn.field.is_rendered());
    EXPECT_EQ(make_map_image(drawn.occupancy).pixels, make_map_image(expected.occupancy).pixels);
    for (const Cell& cell : expected.field.surface_cells()) {
      const auto surface = drawn.field.stored_surface(cell);
      const auto rendered = expected.field.stored_surface(cell);
      ASSERT_EQ(surface.hits, rendered.hits);
      ASSERT_EQ(surface.double_angle_x, rendered.double_angle_x);
      ASSERT_EQ(surface.double_angle_y, rendered.double_angle_y);
    }
  };
  draw();
  renderer_.match_whole(component_, kDefaults);
  EXPECT_TRUE(same_map(renderer_.matched(component_), rendered_all(component_)));

  draw();
  renderer_.begin_whole(component_, kDefaults);
  EXPECT_TRUE(renderer_.is_outdated()) << "another thread renders it";
  renderer_.match_whole(component_, kDefaults);
  EXPECT_TRUE(same_map(renderer_.matched(component_), rendered_all(component_)));
}

TEST_F(MapRendererTest, SaysThatAMapMayTakeLongWhoeverHasAskedForItBefore) {
  move_first(component_, renderer_);
  static_cast<void>(renderer_.whole(component_, kDefaults));
  EXPECT_TRUE(renderer_.begin_whole(component_, kDefaults));
}

TEST_F(MapRendererTest, TakesWhatAnotherRenderedUnlessItHasMovedSince) {
  move_first(component_, renderer_);
  const PlacedScans keys = component_.key_scans.all();
  const SlamMap map = rendered_all(component_);
  move_first(component_, renderer_);
  renderer_.take_rendered(map, keys, component_);
  EXPECT_TRUE(renderer_.is_outdated());

  const PlacedScans now = component_.key_scans.all();
  const SlamMap of_now = rendered_all(component_);
  add(keys_[4], component_, renderer_);  // meanwhile
  renderer_.take_rendered(of_now, now, component_);
  EXPECT_FALSE(renderer_.is_outdated());
  EXPECT_TRUE(same_map(component_.map, of_now));
  EXPECT_TRUE(same_map(renderer_.whole(component_, kDefaults), rendered_all(component_)));
}

}  // namespace
}  // namespace matchbox_slam
