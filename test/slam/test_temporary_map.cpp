#include <gtest/gtest.h>

#include "matching/rendered_map.hpp"
#include "slam/key_scans_of_rooms.hpp"
#include "slam/map_equality.hpp"
#include "slam/temporary_map.hpp"

namespace matchbox_slam {
namespace {

class TemporaryMapTest : public testing::Test {
 protected:
  void add(const PlacedScan& key, int times = 1) {
    for (int i = 0; i < times; ++i) {
      temporary_.add(*key.scan->points(), 1, key.map_from_base, lasting_, map_);
    }
  }
  /// Whether it shows the map and these.
  [[nodiscard]] bool shows(const PlacedScans& scans) const {
    PlacedScans all{keys_[0], keys_[1]};
    all.insert(all.end(), scans.begin(), scans.end());
    return same_map(*temporary_.map(), rendered(all, map_, field_, MapUse::kShown));
  }

  const PlacedScans keys_ = drive_through_rooms(6);
  const MapOptions map_{};  // braces, as clang asks for them
  const LikelihoodFieldOptions field_{};
  const SlamMap lasting_ = rendered({keys_[0], keys_[1]}, map_, field_, MapUse::kShown);
  TemporaryMap temporary_;
};

TEST_F(TemporaryMapTest, ShowsTheMapAndWhatWasSeenSince) {
  EXPECT_EQ(temporary_.map(), nullptr);
  add(keys_[2]);
  add(keys_[3]);
  EXPECT_TRUE(shows({keys_[2], keys_[3]}));
  EXPECT_EQ(temporary_.last_drawn().at(1), keys_[3].map_from_base);
  EXPECT_TRUE(same_map(lasting_, rendered({keys_[0], keys_[1]}, map_, field_, MapUse::kShown)));
  temporary_.clear();
  EXPECT_EQ(temporary_.map(), nullptr);
  EXPECT_TRUE(temporary_.last_drawn().empty());
}

TEST_F(TemporaryMapTest, ForgetsFiftyScansWhenItShowsAHundred) {
  add(keys_[2], 50);
  add(keys_[3], 50);
  PlacedScans all(50, keys_[2]);
  all.insert(all.end(), 50, keys_[3]);
  EXPECT_TRUE(shows(all));
  add(keys_[4]);
  PlacedScans newest(50, keys_[3]);
  newest.push_back(keys_[4]);
  EXPECT_TRUE(shows(newest));
  add(keys_[5]);
  newest.push_back(keys_[5]);
  EXPECT_TRUE(shows(newest));
}

}  // namespace
}  // namespace matchbox_slam
