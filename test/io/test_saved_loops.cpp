// Of io/saved_map.hpp: maps that lie about the graph of the key scans.

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"

namespace matchbox_slam {
namespace {

/// Three key scans, and a loop from the last to the first.
LoopState sound_loops() {
  LoopState loops;
  loops.nodes = 3;
  const Eigen::Matrix3d covariance = 0.01 * Eigen::Matrix3d::Identity();
  loops.edges = {{0, 1, {1.0, 2.0, 3.0}, covariance},
                 {1, 2, {}, covariance},
                 {0, 2, {}, covariance, EdgeKind::kLoop, LoopVerdict::kOutlier}};
  loops.edges[1].drift = {0.001, 0.002, 0.003};
  loops.loops = {{{0, {0.1, 0.2, 0.3}, covariance, 0.9, 0.5, 7.5}, 2, true, 1.5, 0.25}};
  loops.way = 0.75;
  loops.tries = 7;
  loops.pending = PendingLoopWork{1, 1, true, false, true};
  loops.are_others = {false, true};
  return loops;
}

/// The map after it was saved and read.
EngineState saved_with(const LoopState& loops) {
  const EngineOptions options;
  EngineState start{SlamMap(options.map, options.field), {}, {}, {}, 0};
  for (int i = 0; i < 3; ++i) {
    start.key_scans.add(PointScan{}, 0, {});
  }
  start.loops = loops;
  const TemporaryFolder folder;
  replace_file(folder / "map.slam", to_saved_map(start));
  return read_saved_map(folder / "map.slam");
}

std::string error_after(const std::function<void(LoopState&)>& change) {
  LoopState loops = sound_loops();
  change(loops);
  return error_text<FileError>([&] { (void)saved_with(loops); });
}

TEST(SavedLoops, ComeBack) {
  const LoopState sound = sound_loops();
  const LoopState again = saved_with(sound).loops;
  ASSERT_EQ(again.nodes, 3U);
  ASSERT_EQ(again.edges.size(), 3U);
  EXPECT_EQ(again.edges[0].from_to, sound.edges[0].from_to);
  EXPECT_EQ(again.edges[2].from, 0U);
  EXPECT_EQ(again.edges[2].to, 2U);
  EXPECT_EQ(again.edges[2].covariance, sound.edges[2].covariance);
  EXPECT_EQ(again.edges[2].kind, EdgeKind::kLoop);
  EXPECT_EQ(again.edges[2].verdict, LoopVerdict::kOutlier);
  EXPECT_EQ(again.edges[1].drift, sound.edges[1].drift);
  ASSERT_EQ(again.loops.size(), 1U);
  const ClosedLoop& loop = again.loops.front();
  EXPECT_EQ(loop.newest, 2U);
  EXPECT_EQ(loop.found.key_from_newest, sound.loops.front().found.key_from_newest);
  EXPECT_EQ(loop.found.score, 0.9);
  EXPECT_EQ(loop.found.rival_share, 0.5);
  EXPECT_EQ(loop.found.log_odds, 7.5);
  EXPECT_TRUE(loop.is_inlier);
  EXPECT_EQ(loop.chi_square, 1.5);
  EXPECT_EQ(loop.moved, 0.25);
  EXPECT_EQ(again.way, 0.75);
  EXPECT_EQ(again.tries, 7U);
  EXPECT_EQ(again.are_others, (std::vector<bool>{false, true}));
  ASSERT_TRUE(again.pending);
  EXPECT_EQ(again.pending->newest, 1U);
  EXPECT_EQ(again.pending->edges, 1U);
  EXPECT_TRUE(again.pending->is_search_due);
  EXPECT_FALSE(again.pending->is_near_due);
  EXPECT_TRUE(again.pending->is_abandoned);
}

TEST(SavedLoops, NameNoKeyScanThatThereIsNot) {
  const std::string text = "is damaged: it names key scan 3 of a graph of 3";
  EXPECT_TRUE(contains(error_after([](auto& lie) { lie.loops[0].found.key = 3; }), text));
  EXPECT_TRUE(contains(error_after([](auto& lie) { lie.loops[0].newest = 3; }), text));
  EXPECT_TRUE(contains(error_after([](auto& lie) {
                         lie.nodes = 4;
                         lie.edges.push_back({2, 3, {}, Eigen::Matrix3d::Identity()});
                       }),
                       "is damaged: its graph has 4 key scans; the map has 3"));
  EXPECT_TRUE(contains(error_after([](auto& lie) { lie.nodes = 0; }),
                       "is damaged: it names key scan 0 of a graph of 0"));
}

TEST(SavedLoops, GoOnWithKeyScansAndEdgesThatThereAre) {
  EXPECT_TRUE(contains(error_after([](auto& lie) { lie.pending->newest = 3; }),
                       "is damaged: it names key scan 3 of a graph of 3"));
  EXPECT_TRUE(contains(error_after([](auto& lie) { lie.pending->edges = 4; }),
                       "is damaged: it goes on with 4 edges of a graph of 3"));
}

TEST(SavedLoops, GoOnWithAGraphThatWasOne) {
  EXPECT_TRUE(contains(error_after([](auto& lie) { lie.pending->edges = 2; }),
                       "is damaged: pose graph: the edge from node 1 to node 2 ends at a node"));
  EXPECT_TRUE(contains(error_after([](auto& lie) { lie.pending->edges = 0; }),
                       "is damaged: pose graph: no edges of motion join node 1"));
}

TEST(SavedLoops, HoldAGraphThatIsOne) {
  EXPECT_TRUE(contains(error_after([](auto& lie) { lie.edges[1].covariance(0, 1) = 0.02; }),
                       "is damaged: pose graph: the edge from node 1 to node 2 has a covariance"));
  EXPECT_TRUE(contains(error_after([](auto& lie) {
                         lie.edges[1].covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
                       }),
                       "is damaged: it holds the number"));
  EXPECT_TRUE(contains(error_after([](auto& lie) { lie.edges.erase(lie.edges.begin()); }),
                       "is damaged: pose graph: no edges of motion join node"));
  EXPECT_TRUE(
      contains(error_after([](auto& lie) { lie.edges[1].kind = static_cast<EdgeKind>(3); }),
               "is damaged: an edge of its graph is of kind or verdict 3; allowed: up to 2"));
  EXPECT_TRUE(
      contains(error_after([](auto& lie) { lie.edges[1].verdict = static_cast<LoopVerdict>(3); }),
               "is damaged: an edge of its graph is of kind or verdict 3; allowed: up to 2"));
  EXPECT_TRUE(contains(error_after([](auto& lie) { lie.loops[0].found.covariance *= -1.0; }),
                       "is damaged: the covariance of a loop is none"));
}

}  // namespace
}  // namespace matchbox_slam
