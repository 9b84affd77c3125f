#include "matching/olson/scan_level.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace matchbox_slam {
namespace {

constexpr int kMostClusterWeight = 255;  // that sum_windows adds up

// Share of the slack that turns take up, at the useful range; the rest is for neighbours. With half
// of it a search in rooms takes a tenth longer, with 0.8 as long.
constexpr double kTurnShare = 0.625;

// Rounding, of coordinates as far as the search goes, is less.
constexpr double kRounding = 1e-3;  // [cells]

/// Neighbouring points of the scan that one stands for.
class Cluster {
 public:
  Cluster(double x, double y, int weight) : low_(x, y), high_(x, y), weight_(weight) {}

  /// The cluster with one more.
  [[nodiscard]] Cluster with(double x, double y, int weight) const {
    Cluster larger = *this;
    larger.low_ = low_.cwiseMin(Eigen::Vector2d(x, y));
    larger.high_ = high_.cwiseMax(Eigen::Vector2d(x, y));
    larger.weight_ += weight;
    return larger;
  }

  /// Whether turns by up to an angle to each side leave all of it within `slack` of its middle.
  [[nodiscard]] bool fits(double angle, double slack) const {
    return weight_ <= kMostClusterWeight &&
           middle().norm() * angle + 0.5 * (high_ - low_).norm() <= slack;
  }

  [[nodiscard]] Eigen::Vector2d middle() const { return 0.5 * (low_ + high_); }
  [[nodiscard]] int weight() const { return weight_; }

 private:
  Eigen::Vector2d low_;
  Eigen::Vector2d high_;
  int weight_;
};

/// Range below which nine tenths of the points lie [m].
/// @param squares  of ranges, on the way.
double useful_range(const PointArrays& points, std::vector<double>& squares) {
  squares.resize(points.x.size());
  for (std::size_t i = 0; i < squares.size(); ++i) {
    squares[i] = points.x[i] * points.x[i] + points.y[i] * points.y[i];
  }
  const auto rank = static_cast<std::ptrdiff_t>(squares.size() * 9 / 10);
  std::nth_element(squares.begin(), squares.begin() + rank, squares.end());
  return std::sqrt(squares[static_cast<std::size_t>(rank)]);
}

void add(const Cluster& cluster, double angle, double slack, ScanLevel& level) {
  if (!cluster.fits(angle, slack)) {
    level.unbounded += kTopValue * cluster.weight();
    return;
  }
  level.points.x.push_back(cluster.middle().x());
  level.points.y.push_back(cluster.middle().y());
  level.points.weights.push_back(static_cast<std::uint16_t>(cluster.weight()));
}

}  // namespace

void ScanLevels::assign(const PointArrays& points, const SearchLattice& lattice, double resolution,
                        int top) {
  levels_.front().points = points;
  const double arc = points.x.empty() ? 0.0 : lattice.step_theta * useful_range(points, squares_);
  for (std::size_t i = 1; i <= static_cast<std::size_t>(top); ++i) {
    ScanLevel& level = levels_[i];
    level.clear();
    if (points.x.empty()) {
      continue;
    }
    const double slack = resolution * (0.5 * FieldWindow::kBounds.at(i).slack - kRounding);
    const int finer = levels_[i - 1].turns;
    const double most = std::min(2.0 * kTurnShare * slack / arc, 2.0 * lattice.half_theta);
    level.turns = finer * std::max(1, (1 + static_cast<int>(most)) / finer);
    const double angle = 0.5 * lattice.step_theta * (level.turns - 1);
    Cluster cluster(points.x[0], points.y[0], points.weights[0]);
    for (std::size_t p = 1; p < points.x.size(); ++p) {
      const Cluster larger = cluster.with(points.x[p], points.y[p], points.weights[p]);
      if (larger.fits(angle, slack)) {
        cluster = larger;
        continue;
      }
      add(cluster, angle, slack, level);
      cluster = Cluster(points.x[p], points.y[p], points.weights[p]);
    }
    add(cluster, angle, slack, level);
  }
}

}  // namespace matchbox_slam
