#pragma once

#include <vector>

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// A loop is believed when it differs from what the graph without it says by at most this
/// chi-square of 3 degrees of freedom; of right ones 0.1 % exceed it.
constexpr double kMostChiSquare = 16.27;

/// A graph whose poses fit its edges best, with as much of the drift as was learned.
struct OptimisedGraph {
  PoseGraph graph;  ///< every loop is believed or not, and the poses are by those
  /// Of each edge at these poses, by its covariance as assumed; those of disbelieved loops, too.
  std::vector<double> chi_square;
  bool converged = false;  ///< false: it still moved when the optimiser's iterations were used up
};

/// The most likely poses given all edges that are no loops and the loops that can be believed.
///
/// Loops are decided upon by joint compatibility with all that is believed already (Neira and
/// Tardos 2001; over pose graphs Latif, Cadena and Neira 2013), most certain places first: what a
/// loop says is weighed against the graph's own covariance between its two ends. So odometry speaks
/// first, and a row of equal rooms, whose wrong loops agree with one another, gains nothing by
/// their number: its first one has to pass alone. Graduated non-convexity and switchable
/// constraints weigh the sum of all residuals, which many such loops outvote; pairwise consistency
/// asks two loops at a time what all together know better. A believed loop that fits the others no
/// more is dropped. When a new one is turned down, all are decided upon again, beginning with each
/// of the disbelieved ones, and the larger set is kept. Disbelieved loops stay in the graph and are
/// asked again each time.
///
/// Drift is learned (`src/graph/map_drift.hpp`): loops are decided upon with all that is assumed,
/// so that a late one is believed, and the poses are then by what there was.
///
/// The same graph gives the same bits. Throws std::invalid_argument as require_sound does.
[[nodiscard]] OptimisedGraph optimise(PoseGraph graph);

}  // namespace matchbox_slam
