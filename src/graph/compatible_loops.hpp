#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// Errors of loops that a graph which does not use them expects, three rows a loop.
struct LoopErrors {
  std::vector<std::size_t> loops;  ///< numbers of edges
  Eigen::VectorXd error;
  Eigen::MatrixXd covariance;
};

/// By all that is used in the graph, which must not be these loops, or by its motion alone.
[[nodiscard]] LoopErrors expect_errors(const PoseGraph& graph, std::vector<std::size_t> loops,
                                       bool motion_only = false);

/// Places in `errors.loops` of those that are compatible with the graph and one another: asked one
/// after the other, what the graph knows best first, each given those taken before.
/// @param first  place of the one that is asked before all others.
[[nodiscard]] std::vector<std::size_t> compatible_loops(
    LoopErrors errors, double most_chi_square,
    std::size_t first = std::numeric_limits<std::size_t>::max());

/// The inlier that differs most from what the graph would say without it, if by more than that. The
/// poses are where the edges in use fit best.
[[nodiscard]] std::optional<std::size_t> worst_loop(const PoseGraph& graph, double most_chi_square);

}  // namespace matchbox_slam
