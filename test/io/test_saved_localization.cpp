// Of io/saved_map.hpp: maps that lie about where the robot is.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"

namespace matchbox_slam {
namespace {

/// What is wrong with a saved map with two maps apart, in the second of which the robot is, after
/// something is changed.
std::string error_after(const std::function<void(LocalizationState&)>& change) {
  const EngineOptions options;
  const SlamMap map(options.map, options.field);
  EngineState start{map, {}, {}, {}, 0};
  start.localization.components.assign(2, {map, {}, {}, 5.0});
  start.localization.active = 2;
  start.localization.search.hypotheses.assign(2, {1, {}, 3.0, 0.5});
  const PlacedScan scan{std::make_shared<const KeyScan>(MeasuredScan{}, 0, 0), {}};
  start.localization.pending = {{0, scan}};
  change(start.localization);
  const TemporaryFolder folder;
  replace_file(folder / "map.slam", to_saved_map(start));
  return error_text<FileError>([&] { (void)read_saved_map(folder / "map.slam"); });
}

/// A robot that may be elsewhere since its map had no key scan.
HypothesesState doubt() {
  HypothesesState state;
  state.fork = HypothesesFork{0, 1, 0.5, 0.1};
  state.others = {{{1.0, 2.0, 0.3}, -1.5, {std::nullopt}}, {{2.0, 1.0, 0.1}, 0.5, {Pose2{}}}};
  state.elsewhere = -3.0;
  return state;
}

TEST(SavedLocalization, ComeBack) {
  EXPECT_EQ(error_after([](LocalizationState& /*sound*/) {}), "(no error)");
  const EngineOptions options;
  EngineState start{SlamMap(options.map, options.field), {}, {}, {}, 0};
  start.key_scans.add(MeasuredScan{}, 0, {});
  start.localization.hypotheses = doubt();
  start.localization.inserted_before_fork = {{0, {1.0, 0.0, 0.5}}};
  start.localization.search.indexed = 3;
  start.localization.search.sampled = 5;
  start.localization.search.alike = 2;
  start.localization.search.explained = {{7, 0, {1.0, 2.0, 0.25}, 12.5, 3.5}};
  const TemporaryFolder folder;
  replace_file(folder / "map.slam", to_saved_map(start));
  const LocalizationState back = read_saved_map(folder / "map.slam").localization;
  ASSERT_TRUE(back.hypotheses.fork);
  EXPECT_EQ(back.hypotheses.fork->key_scans, 0U);
  EXPECT_EQ(back.hypotheses.fork->inserted, 1U);
  EXPECT_EQ(back.hypotheses.fork->undecided, 0.5);
  EXPECT_EQ(back.hypotheses.fork->searched, 0.1);
  EXPECT_EQ(back.hypotheses.elsewhere, -3.0);
  ASSERT_EQ(back.hypotheses.others.size(), 2U);
  EXPECT_EQ(back.hypotheses.others[0].map_from_base, (Pose2{1.0, 2.0, 0.3}));
  EXPECT_EQ(back.hypotheses.others[0].log_odds, -1.5);
  EXPECT_FALSE(back.hypotheses.others[0].key_scans[0]);
  EXPECT_EQ(*back.hypotheses.others[1].key_scans[0], Pose2{});
  EXPECT_EQ(back.inserted_before_fork.at(0), (Pose2{1.0, 0.0, 0.5}));
  EXPECT_EQ(back.search.indexed, 3U);
  EXPECT_EQ(back.search.sampled, 5);
  EXPECT_EQ(back.search.alike, 2);
  ASSERT_EQ(back.search.explained.size(), 1U);
  EXPECT_EQ(back.search.explained[0].key_scan, 7U);
  EXPECT_EQ(back.search.explained[0].component_from_base, (Pose2{1.0, 2.0, 0.25}));
  EXPECT_EQ(back.search.explained[0].best, 12.5);
  EXPECT_EQ(back.search.explained[0].elsewhere, 3.5);
}

/// As while a robot that is lost knows nothing better yet.
TEST(SavedLocalization, SomewhereUnknownComesBackWithoutAFork) {
  for (const double log_odds : {0.0, -4.2, -std::numeric_limits<double>::infinity()}) {
    EngineState start{SlamMap(MapOptions{}, LikelihoodFieldOptions{}), {}, {}, {}, 0};
    start.localization.hypotheses.elsewhere = log_odds;
    const TemporaryFolder folder;
    replace_file(folder / "map.slam", to_saved_map(start));
    const HypothesesState back = read_saved_map(folder / "map.slam").localization.hypotheses;
    EXPECT_FALSE(back.fork);
    EXPECT_EQ(back.elsewhere, log_odds);
  }
  EXPECT_TRUE(contains(error_after([](LocalizationState& lie) {
                         lie.hypotheses.elsewhere = std::numeric_limits<double>::infinity();
                       }),
                       "is damaged: the log odds of somewhere unknown are .inf"));
}

TEST(SavedLocalization, ForkWhereThereAreKeyScans) {
  EXPECT_TRUE(contains(error_after([](LocalizationState& lie) { lie.hypotheses = doubt(); }),
                       "is damaged: of 0 key scans 0 and 1 are from before and after"));
}

TEST(SavedLocalization, NoMorePlacesLookAlikeThanWereLookedAt) {
  EXPECT_TRUE(contains(error_after([](LocalizationState& lie) {
                         lie.search.sampled = 5;
                         lie.search.alike = 6;
                       }),
                       "is damaged: of 5 places 6 look like others"));
}

/// As while it is made: the frames of maps apart are of their own.
TEST(SavedLocalization, EachMapMayBeAsLargeAsAllowed) {
  const auto with_a_cell_at = [](double x) {
    SlamMap map(MapOptions{}, LikelihoodFieldOptions{});
    map.occupancy.blend(map.occupancy.geometry().cell_at({x, 0.0}), 1.0, 1.0);
    return map;
  };
  EngineState start{with_a_cell_at(0.0), {}, {}, {}, 0};
  start.localization.components.push_back({with_a_cell_at(5000.0), {}, {}, 5.0});
  const TemporaryFolder folder;
  replace_file(folder / "map.slam", to_saved_map(start));
  constexpr double kMostCells = 300.0 * 300.0;
  EXPECT_EQ(error_text<FileError>([&] { (void)read_saved_map(folder / "map.slam", kMostCells); }),
            "(no error)");
}

TEST(SavedLocalization, NameNoComponentThatThereIsNot) {
  const std::string text = "is damaged: it names component 3 of a map of 3";
  EXPECT_TRUE(contains(error_after([](LocalizationState& lie) { lie.active = 3; }), text));
  EXPECT_TRUE(
      contains(error_after([](LocalizationState& lie) { lie.components[1].parent = 3; }), text));
  EXPECT_TRUE(
      contains(error_after([](LocalizationState& lie) { lie.pending[0].component = 3; }), text));
  EXPECT_TRUE(contains(
      error_after([](LocalizationState& lie) { lie.search.hypotheses[1].component = 3; }), text));
}

/// A join would destroy the component that it joins to.
TEST(SavedLocalization, SeekNoComponentInItself) {
  EXPECT_TRUE(
      contains(error_after([](LocalizationState& lie) { lie.search.hypotheses[1].component = 2; }),
               "is damaged: it looks for component 2 of the map in itself"));
}

TEST(SavedLocalization, CountNoMoreThanThereCanBe) {
  for (const int count : {-1, (1 << 30) + 1}) {
    const std::string text = "is damaged: it counts " + std::to_string(count) + " scans";
    EXPECT_TRUE(
        contains(error_after([&](LocalizationState& lie) { lie.search.sampled = count; }), text));
    EXPECT_TRUE(
        contains(error_after([&](LocalizationState& lie) { lie.search.alike = count; }), text));
  }
  EXPECT_TRUE(contains(
      error_after([](LocalizationState& lie) { lie.components.assign(17, lie.components[0]); }),
      "has 17 maps apart; allowed: up to 16"));
  EXPECT_TRUE(
      contains(error_after([](LocalizationState& lie) { lie.search.hypotheses.assign(1001, {}); }),
               "has 1001 places where the robot may be; allowed: up to 1000"));
  EXPECT_TRUE(
      contains(error_after([](LocalizationState& lie) { lie.search.explained.assign(1001, {}); }),
               "has 1001 key scans of a robot that is lost; allowed: up to 1000"));
}

}  // namespace
}  // namespace matchbox_slam
