#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "common/error_text.hpp"
#include "merging/map_merging.hpp"
#include "run/other_maps.hpp"
#include "slam/loop_closing.hpp"
#include "slam/maps_of_rooms.hpp"

namespace matchbox_slam {
namespace {

const Pose2 kOther{7.0, -3.0, 2.0};

/// A run's map, which grows, and what is given to it.
class OtherMapsOfRooms : public testing::Test {
 protected:
  /// The map of the first key scans of the way.
  void see(std::size_t key_scans, const Pose2& map_from_world = {}) {
    std::vector<MergedMap> maps = maps_of(map_of_way(3, 0, key_scans, map_from_world), {});
    const std::lock_guard<std::mutex> lock(mutex_);
    own_ = {std::move(maps.front().component.key_scans), std::move(maps.front().loops), {}};
  }

  /// The map of key scans of the way, in this order.
  void see_numbers(const std::vector<std::size_t>& numbers) {
    const PlacedScans all = map_of_way(3, 0, 100, {}).key_scans.all();
    EngineState map{SlamMap({}, {}), {}, {}, {}};
    for (const std::size_t number : numbers) {
      map.key_scans.add(*all[number].scan->measured(), 0, all[number].map_from_base);
    }
    std::vector<MergedMap> maps = maps_of(map, {});
    const std::lock_guard<std::mutex> lock(mutex_);
    own_ = {std::move(maps.front().component.key_scans), std::move(maps.front().loops), {}};
  }

  std::shared_ptr<const FoundMap> wait_for(std::size_t number) {
    for (int i = 0; i < 5000; ++i) {
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (found_.size() >= number) {
          return found_[number - 1];
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return nullptr;
  }

  void TearDown() override {
    others_.reset();
    EXPECT_EQ(warned_, expected_warnings_);
  }

  /// Until what was seen so far was searched in what was added.
  void wait_until_searched() const {
    while (others_->waiting() == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  [[nodiscard]] std::string error_of(const EngineState& map) {
    return error_text<std::runtime_error>([&] { others_->add("again.slam", map); });
  }

  std::mutex mutex_;
  OwnMap own_;
  std::vector<std::shared_ptr<const FoundMap>> found_;
  std::vector<std::string> told_;
  std::vector<std::string> warned_;
  std::vector<std::string> expected_warnings_;
  std::unique_ptr<OtherMaps> others_ = std::make_unique<OtherMaps>(
      [this] {
        const std::lock_guard<std::mutex> lock(mutex_);
        return own_;
      },
      [this](std::shared_ptr<const FoundMap> found) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (found_.empty() || found_.back() != found) {  // it is given until it is taken in
          found_.push_back(std::move(found));
        }
      },
      RunDialog{[this](const std::string& line) {
                  const std::lock_guard<std::mutex> lock(mutex_);
                  told_.push_back(line);
                },
                [this](const std::string& line) {
                  const std::lock_guard<std::mutex> lock(mutex_);
                  warned_.push_back(line);
                },
                [](double, const std::string&) {}, [] { return false; }});
};

TEST_F(OtherMapsOfRooms, AreNotTakenInWhereBothHaveNoRoom) {
  see(60);
  own_.options.map.max_cells = 1000;
  others_->add("other.slam", map_of_way(3, 30, 100, kOther));
  const auto is_warned = [this] {
    const std::lock_guard<std::mutex> lock(mutex_);
    return !warned_.empty();
  };
  for (int i = 0; i < 5000 && !is_warned(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  ASSERT_EQ(warned_.size(), 1U);
  EXPECT_NE(warned_.front().find("map/max_cells allows 1000.0"), std::string::npos)
      << warned_.front();
  EXPECT_TRUE(found_.empty());
  expected_warnings_ = warned_;
}

TEST_F(OtherMapsOfRooms, GiveUpWithoutWaitingForTheSearch) {
  see(60);
  others_->add("other.slam", map_of_way(3, 30, 100, kOther));
  {
    const std::lock_guard<std::mutex> lock(mutex_);  // the thread waits to look at the own map
    others_->give_up();
  }
  others_.reset();
  EXPECT_TRUE(found_.empty());
}

/// Largest distance [m] of all key scans from where they were taken, when they have come in.
double largest_error(const FoundMap& found, const KeyScans& own_now, std::size_t other_begin) {
  const std::vector<Pose2> way = way_through_rooms(3);
  const std::vector<Pose2> own = moved_with(found.own_moved(), own_now.all());
  double largest = 0.0;
  for (std::size_t i = 0; i < own.size(); ++i) {
    largest = std::max(largest, (own[i].translation() - way[i].translation()).norm());
  }
  const PlacedScans others = others_of(found);
  for (std::size_t i = 0; i < others.size(); ++i) {
    const Eigen::Vector2d off =
        others[i].map_from_base.translation() - way[other_begin + i].translation();
    largest = std::max(largest, off.norm());
  }
  return largest;
}

TEST_F(OtherMapsOfRooms, AreFoundWhereTheyMeetWithWhatHasComeSince) {
  see(25);
  others_->add("other.slam", map_of_way(3, 30, 100, kOther));
  wait_until_searched();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    EXPECT_TRUE(found_.empty()) << "they share no ground yet";
  }
  see(60);
  const std::shared_ptr<const FoundMap> found = wait_for(1);
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->others(), 70U);
  see(70);
  EXPECT_LE(largest_error(*found, own_.key_scans, 30), 0.02);
  found->fate = FoundMap::Fate::kTaken;
  for (int i = 0; i < 100 && others_->waiting() > 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_EQ(others_->waiting(), 0U);
  const std::lock_guard<std::mutex> lock(mutex_);
  ASSERT_EQ(told_.size(), 1U);
  EXPECT_TRUE(contains(told_[0], "other.slam: meets this map; 70 key scans")) << told_[0];
}

/// What waited while the robot was lost comes late into the map, and what was taken back never.
TEST_F(OtherMapsOfRooms, AreSearchedWithKeyScansThatCameLate) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < 25; ++i) {
    if (i != 20 && i != 21) {
      numbers.push_back(i);
    }
  }
  see_numbers(numbers);
  others_->add("other.slam", map_of_way(3, 30, 100, kOther));
  wait_until_searched();
  numbers.erase(numbers.begin() + 10);
  for (std::size_t i = 25; i < 60; ++i) {
    numbers.push_back(i);
  }
  numbers.push_back(20);
  numbers.push_back(21);
  see_numbers(numbers);
  const std::shared_ptr<const FoundMap> found = wait_for(1);
  ASSERT_NE(found, nullptr);
  const std::vector<Pose2> way = way_through_rooms(3);
  const PlacedScans others = others_of(*found);
  ASSERT_EQ(others.size(), 70U);
  for (std::size_t i = 0; i < others.size(); ++i) {
    const Eigen::Vector2d off = others[i].map_from_base.translation() - way[30 + i].translation();
    EXPECT_LE(off.norm(), 0.03) << i;  // 0.021 is measured
  }
}

TEST_F(OtherMapsOfRooms, AreJoinedAgainWhereTheMapHasMovedMeanwhile) {
  see(60);
  others_->add("other.slam", map_of_way(3, 30, 100, kOther));
  const std::shared_ptr<const FoundMap> first = wait_for(1);
  ASSERT_NE(first, nullptr);
  see(60, {0.5, 0.0, 0.0});
  ASSERT_FALSE(begins_with(own_.key_scans.all(), first->own));
  first->fate = FoundMap::Fate::kOutdated;
  const std::shared_ptr<const FoundMap> again = wait_for(2);
  ASSERT_NE(again, nullptr);
  EXPECT_TRUE(begins_with(own_.key_scans.all(), again->own));
}

TEST_F(OtherMapsOfRooms, WhatIsGivenTwiceIsRefused) {
  see(60);
  EXPECT_TRUE(contains(error_of(map_of_way(3, 0, 30, kOther)), "30 of its 30 key scans are in"));
  others_->add("other.slam", map_of_way(4, 30, 60, kOther));
  EXPECT_TRUE(contains(error_of(map_of_way(4, 30, 60, kOther)), "searched already, as other.slam"));
  others_->clear();
  EXPECT_EQ(error_of(map_of_way(4, 30, 60, kOther)), "(no error)");
}

TEST(FoundMap, TheOthersKeyScansComeInBehindTheFirstAndTheNewestStays) {
  const std::vector<MergedMap> own = maps_of(map_of_way(3, 0, 60, {}), {});
  const std::vector<MergedMap> other = maps_of(map_of_way(3, 30, 100, kOther), {});
  const MapMeeting meeting{10, kOther.inverse()};
  std::optional<MergedMap> both = joined(other[0], own[0], meeting, {}, [] {});
  ASSERT_TRUE(both);
  const FoundMap found(own[0].component.key_scans.all(), own[0].loops,
                       std::move(both->component.key_scans), std::move(both->loops));
  KeyScans now = map_of_way(3, 0, 65, {}).key_scans;
  LoopCloser loops(own[0].loops);
  PlacedScans all = found.own;
  for (std::size_t i = 60; i < 65; ++i) {
    all.push_back(now.all()[i]);
  }
  KeyScans keys;
  for (const PlacedScan& key : all) {
    keys.add(key);
    if (keys.size() > 60) {
      loops.add(keys, Eigen::Matrix3d::Identity() * 1e-4, true, {});
    }
  }
  const MapCorrection correction = loops.take_in(found, keys);
  EXPECT_EQ(correction.steps.size(), 65U) << "the other robot's stamps say nothing of this way";
  ASSERT_EQ(loops.state().nodes, 135U);
  ASSERT_EQ(keys.size(), 135U);
  EXPECT_EQ(keys.all().front().scan->stamp(), all.front().scan->stamp());
  EXPECT_EQ(keys.all()[1].scan->stamp(), others_of(found).front().scan->stamp());
  EXPECT_EQ(keys.all().back().scan->stamp(), all.back().scan->stamp());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    EXPECT_EQ(keys.all()[i].scan->id(), i);
  }
  const std::vector<bool> are_others = loops.state().are_others;
  ASSERT_EQ(are_others.size(), 71U);
  EXPECT_FALSE(are_others.front());
  EXPECT_EQ(std::count(are_others.begin(), are_others.end(), true), 70) << "saved with the map";
  // All edges still join what lies where they say.
  for (const PoseEdge& edge : loops.state().edges) {
    const Pose2 from_to =
        keys.all()[edge.from].map_from_base.inverse() * keys.all()[edge.to].map_from_base;
    EXPECT_LE((from_to.translation() - edge.from_to.translation()).norm(), 0.05)
        << edge.from << " " << edge.to;
  }
}

}  // namespace
}  // namespace matchbox_slam
