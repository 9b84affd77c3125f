#include "matchbox_slam/graph/relative_covariances.hpp"

#include <Eigen/Geometry>

#include "graph/graph_information.hpp"

namespace matchbox_slam {

std::vector<Eigen::Matrix3d> relative_covariances(const PoseGraph& graph, std::size_t reference,
                                                  const std::vector<std::size_t>& nodes) {
  require_sound(graph);
  Eigen::Matrix3d reference_from_map = Eigen::Matrix3d::Identity();
  reference_from_map.topLeftCorner<2, 2>() =
      Eigen::Rotation2Dd(-graph.poses.at(reference).theta).toRotationMatrix();
  const auto all = GraphInformation(graph, reference).marginal_covariances();
  std::vector<Eigen::Matrix3d> covariances;
  covariances.reserve(nodes.size());
  for (const std::size_t node : nodes) {
    covariances.push_back(reference_from_map * all.at(node) * reference_from_map.transpose());
  }
  return covariances;
}

}  // namespace matchbox_slam
