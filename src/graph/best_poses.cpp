#include "graph/best_poses.hpp"

#include <ceres/ceres.h>

#include <array>
#include <deque>

#include "graph/edge_error.hpp"

namespace matchbox_slam {
namespace {

using Parameters = std::array<double, 3>;

/// Small, as a long drive has as many as edges: the root is not kept.
class EdgeCost : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  EdgeCost(const PoseEdge& edge, double drift_share) : edge_(&edge), drift_share_(drift_share) {}

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const double* from = parameters[0];
    const double* to = parameters[1];
    const Eigen::Matrix3d root = information_root(covariance_with_drift(*edge_, drift_share_));
    const EdgeError error = edge_error(*edge_, {from[0], from[1], from[2]}, {to[0], to[1], to[2]});
    Eigen::Map<Eigen::Vector3d>{residuals} = root * error.error;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Rows>{jacobians[0]} = root * error.by_from;
    }
    if (jacobians != nullptr && jacobians[1] != nullptr) {
      Eigen::Map<Rows>{jacobians[1]} = root * error.by_to;
    }
    return true;
  }

 private:
  const PoseEdge* edge_;
  double drift_share_;
};

ceres::Solver::Options solver_options(double tolerance) {
  ceres::Solver::Options options;
  options.max_num_iterations = 50;
  options.max_solver_time_in_seconds = 1e9;  // never by the clock: the same bits each time
  options.num_threads = 1;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // As fast here as SuiteSparse, whose sums depend on how many threads its BLAS has.
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.initial_trust_region_radius = 1e8;  // from poses that are nearly right already
  options.function_tolerance = tolerance;
  options.gradient_tolerance = 1e-6;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

void move_to_best_poses(PoseGraph& graph, double tolerance, double drift_share) {
  std::vector<Parameters> poses;
  poses.reserve(graph.poses.size());
  for (const Pose2& pose : graph.poses) {
    poses.push_back({pose.x, pose.y, pose.theta});
  }
  std::deque<EdgeCost> costs;
  ceres::Problem::Options owned_here;
  owned_here.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(owned_here);
  for (const PoseEdge& edge : graph.edges) {
    if (is_used(edge)) {
      problem.AddResidualBlock(&costs.emplace_back(edge, drift_share), nullptr,
                               poses[edge.from].data(), poses[edge.to].data());
    }
  }
  if (problem.NumResiduals() == 0) {
    return;
  }
  problem.SetParameterBlockConstant(poses.front().data());
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(tolerance), &problem, &summary);
  for (std::size_t node = 1; node < poses.size(); ++node) {
    graph.poses[node] = {poses[node][0], poses[node][1], wrap_angle(poses[node][2])};
  }
}

}  // namespace matchbox_slam
