#include "graph/compatible_loops.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <utility>

#include "graph/graph_information.hpp"

namespace matchbox_slam {

using Index = Eigen::Index;

LoopErrors expect_errors(const PoseGraph& graph, std::vector<std::size_t> loops, bool motion_only) {
  LoopErrors result{std::move(loops), {}, {}};
  if (result.loops.empty()) {
    return result;
  }
  const GraphInformation information(graph, {motion_only, 1.0});
  const Eigen::VectorXd change = information.best_change();
  const auto size = 3 * static_cast<Index>(result.loops.size());
  result.error.resize(size);
  result.covariance.resize(size, size);
  std::vector<EdgeError> errors;
  for (const std::size_t loop : result.loops) {
    errors.push_back(edge_error(graph, graph.edges[loop]));
  }
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const PoseEdge& edge = graph.edges[result.loops[i]];
    const auto at = 3 * static_cast<Index>(i);
    result.error.segment<3>(at) = errors[i].error + information.error_of(edge, errors[i], change);
    const GraphInformation::Change with = information.covariance_with(edge, errors[i]);
    for (std::size_t j = 0; j < errors.size(); ++j) {
      result.covariance.block<3, 3>(3 * static_cast<Index>(j), at) =
          information.error_of(graph.edges[result.loops[j]], errors[j], with);
    }
    result.covariance.block<3, 3>(at, at) += edge.covariance;
  }
  return result;
}

std::vector<std::size_t> compatible_loops(LoopErrors errors, double most_chi_square,
                                          std::size_t first) {
  std::vector<std::size_t> open(errors.loops.size());
  std::iota(open.begin(), open.end(), std::size_t{0});
  const auto block = [&](std::size_t loop) {
    const auto at = 3 * static_cast<Index>(loop);
    return errors.covariance.block<3, 3>(at, at);
  };
  std::vector<std::size_t> taken;
  while (!open.empty()) {
    auto next = std::find(open.begin(), open.end(), first);
    if (next == open.end()) {
      next = std::min_element(open.begin(), open.end(), [&](std::size_t a, std::size_t b) {
        return block(a).determinant() < block(b).determinant();
      });
    }
    const std::size_t loop = *next;
    open.erase(next);
    const auto at = 3 * static_cast<Index>(loop);
    const Eigen::Vector3d error = errors.error.segment<3>(at);
    const Eigen::Matrix3d inverse = block(loop).inverse();
    if (chi_square(error, block(loop)) > most_chi_square) {
      continue;
    }
    taken.push_back(loop);
    const Eigen::Matrix<double, Eigen::Dynamic, 3> with =
        errors.covariance.middleCols<3>(at);  // what the others learn from this one
    errors.error -= with * (inverse * error);
    errors.covariance.noalias() -= with * inverse * with.transpose();
  }
  return taken;
}

std::optional<std::size_t> worst_loop(const PoseGraph& graph, double most_chi_square) {
  std::vector<std::size_t> loops;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const PoseEdge& edge = graph.edges[i];
    // A loop that hardly gave way has no other that contradicts it, and rounding would decide.
    constexpr double kMinChiSquareShare = 1e-6;
    if (edge.kind == EdgeKind::kLoop && is_used(edge) &&
        chi_square(edge_error(graph, edge).error, edge.covariance) >
            kMinChiSquareShare * most_chi_square) {
      loops.push_back(i);
    }
  }
  if (loops.empty()) {
    return std::nullopt;
  }
  const auto covariances = GraphInformation(graph, {}).error_covariances(graph, loops);
  std::optional<std::size_t> worst;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    const PoseEdge& edge = graph.edges[loops[i]];
    const double without =
        chi_square(edge_error(graph, edge).error, edge.covariance - covariances[i]);
    if (without > most_chi_square) {
      most_chi_square = without;
      worst = loops[i];
    }
  }
  return worst;
}

}  // namespace matchbox_slam
