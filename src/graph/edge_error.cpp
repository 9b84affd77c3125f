#include "graph/edge_error.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace matchbox_slam {

EdgeError edge_error(const PoseEdge& edge, const Pose2& map_from_from, const Pose2& map_from_to) {
  const double c = std::cos(map_from_from.theta);
  const double s = std::sin(map_from_from.theta);
  const Pose2 from_to = map_from_from.inverse() * map_from_to;
  EdgeError result;
  result.error = difference(from_to, edge.from_to);
  result.by_to << c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0;
  result.by_from = -result.by_to;
  result.by_from.col(2) << from_to.y, -from_to.x, -1.0;
  return result;
}

EdgeError edge_error(const PoseGraph& graph, const PoseEdge& edge) {
  return edge_error(edge, graph.poses[edge.from], graph.poses[edge.to]);
}

Eigen::Matrix3d covariance_with_drift(const PoseEdge& edge, double share) {
  Eigen::Matrix3d covariance = edge.covariance;
  covariance.diagonal() -= (1.0 - share) * edge.drift;
  return covariance;
}

Eigen::Matrix3d information_root(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d lower = covariance.llt().matrixL();
  return lower.triangularView<Eigen::Lower>().solve(Eigen::Matrix3d::Identity());
}

}  // namespace matchbox_slam
