#include "graph/map_drift.hpp"

#include <algorithm>
#include <cmath>

#include "graph/graph_information.hpp"

namespace matchbox_slam {
namespace {

/// Log-likelihood of the inliers given the motion, up to what does not depend on the drift: that
/// of all edges less that of the motion, each with its poses integrated out (Laplace).
double log_likelihood_of_loops(const PoseGraph& graph, double drift_share) {
  const auto without_poses = [&](bool motion_only) {
    const GraphInformation information(graph, {motion_only, drift_share});
    return information.least_chi_square() + information.log_determinant();
  };
  return 0.5 * (without_poses(true) - without_poses(false));
}

}  // namespace

double learn_drift(const PoseGraph& graph) {
  const bool is_told = std::any_of(graph.edges.begin(), graph.edges.end(), [](const auto& edge) {
    return edge.kind == EdgeKind::kLoop && is_used(edge);
  });
  const bool has_drift = std::any_of(graph.edges.begin(), graph.edges.end(),
                                     [](const auto& edge) { return !edge.drift.isZero(); });
  if (!is_told || !has_drift) {
    return 1.0;
  }
  // A priori its deviation is what is assumed, half of it is 1.4 deviations of a normal
  // distribution by its logarithm away.
  const auto log_posterior = [&](double share) {
    const double halvings = -0.5 * std::log2(share);
    return log_likelihood_of_loops(graph, share) - halvings * halvings;
  };
  double share = 1.0;
  double most = log_posterior(share);
  while (share > kLeastDriftShare) {
    const double next = log_posterior(0.25 * share);
    if (!(next > most)) {
      break;
    }
    most = next;
    share *= 0.25;
  }
  return share;
}

}  // namespace matchbox_slam
