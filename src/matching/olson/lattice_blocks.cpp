#include "matching/olson/lattice_blocks.hpp"

#include <array>

namespace matchbox_slam {
namespace {

/// Rounded towards minus infinity, for a positive divisor.
int floor_div(int value, int divisor) {
  const int quotient = value / divisor;
  return quotient * divisor > value ? quotient - 1 : quotient;
}

}  // namespace

void LatticeBlocks::assign(const PointArrays& points, const SearchLattice& lattice,
                           double resolution) {
  lattice_ = lattice;
  resolution_ = resolution;
  top_ = 1;
  // More blocks along an axis than this are worth a coarser level.
  constexpr std::array<int, FieldWindow::kLevels> kMostBlocks = {0, 8, 12, 0};
  while (top_ < FieldWindow::kLevels - 1 &&
         blocks_of(top_).count() > kMostBlocks[static_cast<std::size_t>(top_)]) {
    ++top_;
  }
  levels_.assign(points, lattice_, resolution_, top_);
}

StepRange LatticeBlocks::blocks_of(int level) const {
  const int width = width_of(level);
  return {floor_div(-lattice_.half_xy, width), floor_div(lattice_.half_xy, width)};
}

}  // namespace matchbox_slam
