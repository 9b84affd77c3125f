#pragma once

#include <vector>

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// A graph whose poses fit its edges best, with as much of the drift as was learned.
struct OptimisedGraph {
  PoseGraph graph;  ///< every loop is an inlier or an outlier, and the poses are by the inliers
  /// Of each edge at these poses, by its covariance as assumed; those of outliers, too.
  std::vector<double> chi_square;
};

/// The most likely poses given all edges that are no loops and the loops that are inliers.
///
/// A loop is an inlier when it differs from what the graph without it says by kMostChiSquare at
/// most. Loops are decided upon by joint compatibility with the inliers that there are (Neira and
/// Tardos 2001; over pose graphs Latif, Cadena and Neira 2013), most certain places first: what a
/// loop says is weighed against the graph's own covariance between its two ends. So odometry speaks
/// first, and a row of equal rooms, whose wrong loops agree with one another, gains nothing by
/// their number: its first one has to pass alone. Graduated non-convexity and switchable
/// constraints weigh the sum of all residuals, which many such loops outvote; pairwise consistency
/// asks two loops at a time what all together know better. An inlier that fits the others no
/// more becomes an outlier. When a new one is turned down, all are decided upon again, beginning
/// with each of the outliers, and the larger set is kept. Outliers stay in the graph and are
/// decided upon again each time.
///
/// Drift is learned (`src/graph/map_drift.hpp`): loops are decided upon with all that is assumed,
/// so that a late one is an inlier, and the poses are then by what there was.
///
/// The same graph gives the same bits. Throws std::invalid_argument as require_sound does.
[[nodiscard]] OptimisedGraph optimise(PoseGraph graph);

}  // namespace matchbox_slam
