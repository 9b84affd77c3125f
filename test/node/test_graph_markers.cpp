#include <gtest/gtest.h>

#include <cmath>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "node/graph_markers.hpp"

namespace matchbox_slam {
namespace {

using visualization_msgs::Marker;

/// A loop that is off by so much [m] in x, which is known to 0.1 m.
PoseEdge loop(LoopVerdict verdict, double off) {
  return {0, 2, {off, 1.0, 0.0}, covariance_of(0.1, 0.1), EdgeKind::kLoop, verdict};
}

/// Three poses, driven one after the other.
PoseGraph small_graph() {
  const Eigen::Matrix3d covariance = covariance_of(0.1, 0.1);
  return {{{0.0, 0.0, 0.0}, {1.0, 0.0, 1.0}, {0.0, 1.0, 0.0}},
          {{0, 1, {1.0, 0.0, 1.0}, covariance}, {1, 2, {-0.5, 0.5, 0.0}, covariance}}};
}

void expect_line(const Marker& lines, std::size_t number, const Pose2& from, const Pose2& to) {
  ASSERT_GT(lines.points.size(), 2 * number + 1);
  const auto& begin = lines.points[2 * number];
  const auto& end = lines.points[2 * number + 1];
  EXPECT_EQ(Eigen::Vector2d(begin.x, begin.y), from.translation());
  EXPECT_EQ(Eigen::Vector2d(end.x, end.y), to.translation());
}

TEST(GraphMarkers, DrawsEdgesByTheirKind) {
  PoseGraph graph = small_graph();
  graph.edges.push_back(loop(LoopVerdict::kInlier, 0.0));
  graph.edges.push_back(loop(LoopVerdict::kOutlier, 9.0));
  const auto markers = to_markers(graph, "map", ros::Time(7.0)).markers;
  ASSERT_EQ(markers.size(), 3U);
  const std::vector<std::string> names = {"motion", "loops", "refused"};
  for (std::size_t i = 0; i < 3; ++i) {
    const Marker& marker = markers[i];
    EXPECT_EQ(marker.ns, names[i]);
    EXPECT_EQ(marker.type, Marker::LINE_LIST);
    EXPECT_EQ(marker.action, Marker::ADD);
    EXPECT_EQ(marker.header.frame_id, "map");
    EXPECT_EQ(marker.header.stamp, ros::Time(7.0));
    EXPECT_EQ(marker.pose.orientation.w, 1.0) << "rviz refuses what is no rotation";
    EXPECT_EQ(marker.points.size(), i == 0 ? 4U : 2U);
    EXPECT_EQ(marker.colors.size(), marker.points.size());
  }
  expect_line(markers[0], 0, graph.poses[0], graph.poses[1]);
  expect_line(markers[0], 1, graph.poses[1], graph.poses[2]);
  expect_line(markers[1], 0, graph.poses[0], graph.poses[2]);
  expect_line(markers[2], 0, graph.poses[0], graph.poses[2]);
  EXPECT_GT(markers[1].scale.x, 2.0 * markers[2].scale.x) << "loops are seen, refused ones thin";
  EXPECT_NE(markers[1].colors[0], markers[2].colors[0]);
}

TEST(GraphMarkers, ColoursLoopsByTheirResidual) {
  const auto color_of = [](double off) {
    PoseGraph graph = small_graph();
    graph.edges.push_back(loop(LoopVerdict::kInlier, off));
    return to_markers(graph, "map", {}).markers[1].colors[1];
  };
  EXPECT_EQ(color_of(0.0).g, 1.0F);
  EXPECT_EQ(color_of(0.0).r, 0.0F);
  const double most = 0.1 * std::sqrt(16.27);  // [m]
  EXPECT_NEAR(color_of(std::sqrt(0.25) * most).r, 0.5F, 1e-6);
  EXPECT_NEAR(color_of(std::sqrt(0.75) * most).g, 0.5F, 1e-6);
  EXPECT_EQ(color_of(2.0 * most).r, 1.0F);
  EXPECT_EQ(color_of(2.0 * most).g, 0.0F);
}

TEST(GraphMarkers, DeletesWhatThereIsNoMore) {
  for (const Marker& marker : to_markers(small_graph(), "map", {}).markers) {
    EXPECT_EQ(marker.action, marker.ns == "motion" ? Marker::ADD : Marker::DELETE) << marker.ns;
  }
}

}  // namespace
}  // namespace matchbox_slam
