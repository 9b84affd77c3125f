#pragma once

#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

struct GraphOptions {
  double most_chi_square = 16.27;
  int max_iterations = 50;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.most_chi_square, "most_chi_square", at_least(0.0), "",
           "A loop is believed when it differs from what the graph without it says by at most this "
           "chi-square of 3 degrees of freedom; of right ones 0.1 % exceed 16.27.");
    option(self.max_iterations, "max_iterations", at_least(1.0), "",
           "Iterations of the optimiser at most, each time.");
  }
};

/// A graph whose poses fit its edges best, with as much of the drift as was learned.
struct OptimisedGraph {
  PoseGraph graph;  ///< every loop is believed or not, and the poses are by those
  /// Of each edge at these poses, by its covariance as assumed; those of disbelieved loops, too.
  std::vector<double> chi_square;
  int iterations = 0;      ///< of the optimiser, all in all
  bool converged = false;  ///< false: it still moved when the iterations were used up
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
[[nodiscard]] OptimisedGraph optimise(PoseGraph graph, const GraphOptions& options = {});

}  // namespace matchbox_slam
