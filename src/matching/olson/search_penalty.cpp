#include "matching/olson/search_penalty.hpp"

#include <Eigen/QR>

namespace matchbox_slam {

SearchPenalty::SearchPenalty(const SearchLattice& lattice, const SearchScoring& scoring,
                             double resolution)
    : information_(scoring.prior_information),
      weight_(scoring.prior_weight),
      step_xy_(lattice.step_xy(resolution)),
      step_theta_(lattice.step_theta) {
  // Also where translations in some direction cost nothing.
  const Eigen::Matrix2d translation = information_.topLeftCorner<2, 2>();
  const Eigen::Vector2d coupling = information_.topRightCorner<2, 1>();
  follows_ = -translation.completeOrthogonalDecomposition().solve(coupling);
}

}  // namespace matchbox_slam
