#include "io/g2o.hpp"

#include <Eigen/LU>
#include <limits>
#include <locale>
#include <sstream>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {

std::string to_g2o(const PoseGraph& graph) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(std::numeric_limits<double>::max_digits10);
  for (std::size_t node = 0; node < graph.poses.size(); ++node) {
    const Pose2& pose = graph.poses[node];
    text << "VERTEX_SE2 " << node << ' ' << pose.x << ' ' << pose.y << ' ' << pose.theta << '\n';
  }
  text << "FIX 0\n";
  for (const PoseEdge& edge : graph.edges) {
    if (!is_used(edge)) {
      continue;
    }
    const Pose2& pose = edge.from_to;
    text << "EDGE_SE2 " << edge.from << ' ' << edge.to << ' ' << pose.x << ' ' << pose.y << ' '
         << pose.theta;
    const Eigen::Matrix3d information = in_turned_frame(edge.covariance, pose.theta).inverse();
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column) {
        text << ' ' << information(row, column);
      }
    }
    text << '\n';
  }
  return text.str();
}

void write_g2o(const std::string& path, const PoseGraph& graph) {
  replace_file(path, to_g2o(graph));
}

}  // namespace matchbox_slam
