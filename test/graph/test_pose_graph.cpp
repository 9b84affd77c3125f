#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {
namespace {

PoseGraph three_nodes() {
  PoseGraph graph;
  graph.poses = {{}, {1.0, 0.0, 0.0}, {2.0, 0.0, 0.0}};
  const Eigen::Matrix3d covariance = 1e-4 * Eigen::Matrix3d::Identity();
  graph.edges = {{0, 1, {1.0, 0.0, 0.0}, covariance}, {1, 2, {1.0, 0.0, 0.0}, covariance}};
  return graph;
}

void expect_error(const PoseGraph& graph, const std::string& text) {
  try {
    require_sound(graph);
    ADD_FAILURE() << "expected: " << text;
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
  }
}

TEST(PoseGraph, ASoundOneIsTaken) {
  EXPECT_NO_THROW(require_sound(three_nodes()));
  PoseGraph single;
  single.poses.resize(1);
  EXPECT_NO_THROW(require_sound(single));
}

TEST(PoseGraph, AStateIsTakenBack) {
  PoseGraph graph = three_nodes();
  graph.edges[1].kind = EdgeKind::kLoop;
  graph.edges[1].verdict = LoopVerdict::kInlier;
  const GraphState state = state_of(graph);
  PoseGraph changed = graph;
  changed.poses[2].x = 3.0;
  changed.edges[1].verdict = LoopVerdict::kOutlier;
  set_state(state, changed);
  EXPECT_EQ(changed.poses, graph.poses);
  EXPECT_EQ(changed.edges[1].verdict, LoopVerdict::kInlier);
}

TEST(PoseGraph, EdgesAreAddedWithLittleMemoryToSpare) {
  PoseGraph graph = three_nodes();
  for (std::size_t i = 0; i < 1000; ++i) {
    PoseEdge edge = graph.edges[0];
    edge.from_to.x = static_cast<double>(i);
    add_edge(edge, graph.edges);
    ASSERT_LE(graph.edges.capacity(), graph.edges.size() + graph.edges.size() / 8 + 16);
  }
  ASSERT_EQ(graph.edges.size(), 1002U);
  EXPECT_EQ(graph.edges[1001].from_to.x, 999.0);
}

TEST(PoseGraph, NodesThatMotionDoesNotJoinAreNamed) {
  expect_error({}, "it has no nodes");
  PoseGraph graph = three_nodes();
  graph.edges[1].kind = EdgeKind::kLoop;
  graph.edges[1].verdict = LoopVerdict::kInlier;
  expect_error(graph, "no edges of motion join node 2 to the first one");
  graph.edges.clear();
  expect_error(graph, "no edges of motion join node 1 to the first one");
}

TEST(PoseGraph, PosesThatAreNotFiniteAreNamed) {
  PoseGraph graph = three_nodes();
  graph.poses[2].theta = std::numeric_limits<double>::quiet_NaN();
  expect_error(graph, "the pose of node 2 is not finite");
}

TEST(PoseGraph, EdgesThatAreWrongAreNamed) {
  const auto expect_edge_error = [](const auto& spoil, const std::string& text) {
    PoseGraph graph = three_nodes();
    graph.edges.push_back(graph.edges.back());
    graph.edges.back().kind = EdgeKind::kLoop;
    spoil(graph.edges.back());
    expect_error(graph, text);
  };
  expect_edge_error([](PoseEdge& edge) { edge.to = 3; },
                    "the loop from node 1 to node 3 ends at a node that there is not; there are 3");
  expect_edge_error([](PoseEdge& edge) { edge.to = 1; },
                    "the loop from node 1 to node 1 joins it to itself");
  expect_edge_error(
      [](PoseEdge& edge) { edge.from_to.x = std::numeric_limits<double>::infinity(); },
      "the loop from node 1 to node 2 measured a pose that is not finite");
  const std::string covariance =
      "the loop from node 1 to node 2 has a covariance that is not finite, symmetric and positive "
      "definite";
  expect_edge_error([](PoseEdge& edge) { edge.covariance(0, 0) = std::nan(""); }, covariance);
  expect_edge_error([](PoseEdge& edge) { edge.covariance(0, 1) = 1e-5; }, covariance);
  expect_edge_error([](PoseEdge& edge) { edge.covariance.setZero(); }, covariance);
  const std::string drift =
      "the loop from node 1 to node 2 has a drift that is not a part of its covariance";
  expect_edge_error([](PoseEdge& edge) { edge.drift = {2e-4, 0.0, 0.0}; }, drift);
  expect_edge_error([](PoseEdge& edge) { edge.drift = {0.0, 0.0, 1.1e-4}; }, drift);
  expect_edge_error([](PoseEdge& edge) { edge.drift = {0.0, -1e-5, 0.0}; }, drift);
  expect_edge_error([](PoseEdge& edge) { edge.drift = {0.0, 0.0, std::nan("")}; }, drift);
}

}  // namespace
}  // namespace matchbox_slam
