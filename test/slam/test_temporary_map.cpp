#include <gtest/gtest.h>

#include "matching/rendered_map.hpp"
#include "slam/key_scans_of_rooms.hpp"
#include "slam/map_equality.hpp"
#include "slam/temporary_map.hpp"

namespace matchbox_slam {
namespace {

TEST(TemporaryMap, ShowsTheMapAndTheScansOfLate) {
  const PlacedScans keys = drive_through_rooms(6);
  const MapOptions map;
  const LikelihoodFieldOptions field;
  const SlamMap lasting = rendered({keys[0], keys[1]}, map, field);
  const SlamMap kept = lasting;
  TemporaryMap temporary;
  EXPECT_EQ(temporary.map(), nullptr);
  const auto add = [&](const PlacedScan& key) {
    temporary.add(key, *key.scan->points(), lasting, map);
  };
  add(keys[2]);
  add(keys[3]);
  ASSERT_NE(temporary.map(), nullptr);
  EXPECT_TRUE(
      same_map(*temporary.map(), rendered({keys[0], keys[1], keys[2], keys[3]}, map, field)));
  for (int i = 0; i < 98; ++i) {
    add(keys[4]);
  }
  EXPECT_FALSE(same_map(*temporary.map(), lasting));
  // One more than there is room for, and what is older than the newest fifty is forgotten.
  add(keys[5]);
  PlacedScans newest{keys[0], keys[1]};
  newest.insert(newest.end(), 49, keys[4]);
  newest.push_back(keys[5]);
  EXPECT_TRUE(same_map(*temporary.map(), rendered(newest, map, field)));
  EXPECT_TRUE(same_map(lasting, kept));
  temporary.clear();
  EXPECT_EQ(temporary.map(), nullptr);
}

}  // namespace
}  // namespace matchbox_slam
