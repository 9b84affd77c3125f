#include "node/graph_markers.hpp"

#include <algorithm>

#include "graph/edge_error.hpp"
#include "matchbox_slam/geometry/chi_square.hpp"

namespace matchbox_slam {
namespace {

using visualization_msgs::Marker;

std_msgs::ColorRGBA color(double red, double green, double blue) {
  std_msgs::ColorRGBA color;
  color.r = static_cast<float>(red);
  color.g = static_cast<float>(green);
  color.b = static_cast<float>(blue);
  color.a = 1.0F;
  return color;
}

std_msgs::ColorRGBA color_of(const PoseGraph& graph, const PoseEdge& edge) {
  if (edge.kind != EdgeKind::kLoop) {
    return color(0.35, 0.65, 0.85);
  }
  if (!is_used(edge)) {
    return color(0.6, 0.2, 0.8);
  }
  const double residual = chi_square(edge_error(graph, edge).error, edge.covariance);
  const double share = std::min(1.0, residual / kMostChiSquare);
  return color(std::min(1.0, 2.0 * share), std::min(1.0, 2.0 - 2.0 * share), 0.0);
}

geometry_msgs::Point point_of(const Pose2& pose) {
  constexpr double kHeight = 0.05;  // [m], so that lines lie on the map and on the paths
  geometry_msgs::Point point;
  point.x = pose.x;
  point.y = pose.y;
  point.z = kHeight;
  return point;
}

}  // namespace

visualization_msgs::MarkerArray to_markers(const PoseGraph& graph, const std::string& map_frame,
                                           const ros::Time& stamp) {
  constexpr double kThinLineWidth = 0.03;   // [m]
  constexpr double kThickLineWidth = 0.12;  // [m]
  visualization_msgs::MarkerArray markers;
  const auto add = [&](const std::string& name, double width, const auto& is_in) {
    Marker marker;
    marker.header.frame_id = map_frame;
    marker.header.stamp = stamp;
    marker.ns = name;
    marker.type = Marker::LINE_LIST;
    marker.pose.orientation.w = 1.0;
    marker.scale.x = width;
    for (const PoseEdge& edge : graph.edges) {
      if (is_in(edge)) {
        marker.points.push_back(point_of(graph.poses[edge.from]));
        marker.points.push_back(point_of(graph.poses[edge.to]));
        marker.colors.insert(marker.colors.end(), 2, color_of(graph, edge));
      }
    }
    marker.action = marker.points.empty() ? Marker::DELETE : Marker::ADD;
    markers.markers.push_back(marker);
  };
  const auto is_motion = [](const PoseEdge& edge) { return edge.kind != EdgeKind::kLoop; };
  add("motion", kThinLineWidth, is_motion);
  add("loops", kThickLineWidth,
      [&](const PoseEdge& edge) { return !is_motion(edge) && is_used(edge); });
  add("refused", kThinLineWidth, [](const PoseEdge& edge) { return !is_used(edge); });
  return markers;
}

}  // namespace matchbox_slam
