#include "slam/slip_inflation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

// Guesses (benchmark/reports/current/LOOPS.md, "Wheels that slip").
constexpr double kMinSpeed = 0.2;       // [m/s]
constexpr double kMaxSpeedRatio = 0.6;  // of its speed before and after
constexpr double kMaxSlipTime = 6.0;    // [s], else it stands
constexpr double kMinHidden = 0.3;      // [m] that are hidden
constexpr double kMaxTurn = 0.3;        // [rad]; who turns slows down for it
constexpr double kSigmaShare = 0.5;     // of what is hidden is its standard deviation
constexpr double kMinSigma = 0.02;      // [m], standard deviation by scans and odometry

/// From one key scan to the next.
struct Leg {
  std::size_t to = 0;
  double seconds = 0.0;
  Eigen::Vector2d way = Eigen::Vector2d::Zero();  ///< [m] in the map frame
  double turn = 0.0;                              ///< [rad], its amount

  [[nodiscard]] bool is_in_order() const { return seconds > 0.0; }
  [[nodiscard]] double speed() const { return way.norm() / seconds; }
};

Leg leg_to(std::size_t key, const PlacedScans& keys) {
  const PlacedScan& from = keys[key - 1];
  const PlacedScan& to = keys[key];
  return {key, to.scan->stamp() - from.scan->stamp(),
          to.map_from_base.translation() - from.map_from_base.translation(),
          std::abs(wrap_angle(to.map_from_base.theta - from.map_from_base.theta))};
}

/// Legs that are slower than those before and after.
struct SlowStretch {
  Leg before;
  std::vector<Leg> legs;  ///< newest first; none where there is no such stretch
  Leg after;

  [[nodiscard]] double usual() const { return std::min(before.speed(), after.speed()); }
  [[nodiscard]] double hidden(const Leg& leg) const {
    return std::max(0.0, usual() * leg.seconds - leg.way.norm());
  }
  [[nodiscard]] bool is_straight() const {
    const bool turns =
        std::any_of(legs.begin(), legs.end(), [](const Leg& leg) { return leg.turn >= kMaxTurn; });
    return !turns && before.turn < kMaxTurn && after.turn < kMaxTurn &&
           before.way.normalized().dot(after.way.normalized()) > std::cos(kMaxTurn);
  }
};

SlowStretch slow_stretch(const PlacedScans& keys, std::size_t end) {
  SlowStretch stretch;
  stretch.after = leg_to(end + 1, keys);
  double seconds = 0.0;
  for (std::size_t key = end; key > 0; --key) {
    stretch.before = leg_to(key, keys);
    seconds += stretch.before.seconds;
    if (!stretch.before.is_in_order()) {
      break;
    }
    if (stretch.before.speed() > kMaxSpeedRatio * stretch.after.speed()) {
      return stretch;
    }
    if (seconds > kMaxSlipTime) {
      break;
    }
    stretch.legs.push_back(stretch.before);
  }
  stretch.legs.clear();
  return stretch;
}

/// Widens the edge of motion of a leg along a direction of the map, unless scans tell how far it
/// was.
void widen(const Leg& leg, const Eigen::Vector2d& along_in_map, double variance,
           const PlacedScans& keys, std::vector<PoseEdge>& edges) {
  const auto edge = std::find_if(edges.rbegin(), edges.rend(), [&](const auto& one) {
    return one.from + 1 == leg.to && one.to == leg.to && one.kind == EdgeKind::kMotion;
  });
  if (edge == edges.rend()) {
    return;
  }
  const Eigen::Vector2d along =
      Eigen::Rotation2Dd(-keys[leg.to - 1].map_from_base.theta) * along_in_map;
  const double seen = along.dot(edge->covariance.topLeftCorner<2, 2>() * along) -
                      along.cwiseAbs2().dot(edge->drift.head<2>());
  if (seen > kMinSigma * kMinSigma) {
    edge->covariance.topLeftCorner<2, 2>() += variance * along * along.transpose();
  }
}

}  // namespace

void inflate_for_slip(const PlacedScans& keys, std::size_t key, std::vector<PoseEdge>& edges) {
  if (key + 1 >= keys.size()) {
    return;
  }
  const SlowStretch stretch = slow_stretch(keys, key);
  if (stretch.legs.empty() || stretch.usual() < kMinSpeed || !stretch.is_straight()) {
    return;
  }
  double hidden = 0.0;
  for (const Leg& leg : stretch.legs) {
    hidden += stretch.hidden(leg);
  }
  if (hidden < kMinHidden) {
    return;
  }
  for (const Leg& leg : stretch.legs) {  // all at once: what is hidden in one is in the others
    const double variance = kSigmaShare * kSigmaShare * hidden * stretch.hidden(leg);
    widen(leg, stretch.before.way.normalized(), variance, keys, edges);
  }
}

}  // namespace matchbox_slam
