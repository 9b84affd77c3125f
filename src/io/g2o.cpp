#include "io/g2o.hpp"

#include <Eigen/LU>
#include <limits>
#include <ostream>

#include "io/paged_text.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"

namespace matchbox_slam {

void write_g2o(const PoseGraph& graph, const ByteSink& sink) {
  PagedText text(sink);
  text.line().precision(std::numeric_limits<double>::max_digits10);
  for (std::size_t node = 0; node < graph.poses.size(); ++node) {
    const Pose2& pose = graph.poses[node];
    text.line() << "VERTEX_SE2 " << node << ' ' << pose.x << ' ' << pose.y << ' ' << pose.theta;
    text.end_line();
  }
  text.line() << "FIX 0";
  text.end_line();
  for (const PoseEdge& edge : graph.edges) {
    if (!is_used(edge)) {
      continue;
    }
    const Pose2& pose = edge.from_to;
    text.line() << "EDGE_SE2 " << edge.from << ' ' << edge.to << ' ' << pose.x << ' ' << pose.y
                << ' ' << pose.theta;
    const Eigen::Matrix3d information = in_turned_frame(edge.covariance, pose.theta).inverse();
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column) {
        text.line() << ' ' << information(row, column);
      }
    }
    text.end_line();
  }
  text.finish();
}

std::string to_g2o(const PoseGraph& graph) {
  return text_of_pages([&](const ByteSink& sink) { write_g2o(graph, sink); });
}

void write_g2o(const std::string& path, const PoseGraph& graph) {
  replace_file(path, to_g2o(graph));
}

}  // namespace matchbox_slam
