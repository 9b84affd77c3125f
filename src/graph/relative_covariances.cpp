#include "matchbox_slam/graph/relative_covariances.hpp"

#include "graph/graph_information.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"

namespace matchbox_slam {

std::vector<Eigen::Matrix3d> relative_covariances(const PoseGraph& graph, std::size_t reference,
                                                  const std::vector<std::size_t>& nodes) {
  require_sound(graph);
  const double theta = graph.poses.at(reference).theta;
  const auto all = GraphInformation(graph, reference, {}).marginal_covariances();
  std::vector<Eigen::Matrix3d> covariances;
  covariances.reserve(nodes.size());
  for (const std::size_t node : nodes) {
    covariances.push_back(in_turned_frame(all.at(node), theta));
  }
  return covariances;
}

}  // namespace matchbox_slam
