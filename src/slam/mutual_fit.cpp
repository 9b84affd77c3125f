#include "slam/mutual_fit.hpp"

#include <algorithm>

#include "map/scan_drawing.hpp"

namespace matchbox_slam {
namespace {

/// As of what lies on the map, all together.
GroundShares shares_of_all(const PlacedScans& keys, const SlamMap& map) {
  PointScan all;
  for (const PlacedScan& key : keys) {
    append(*key.scan->points(), key.map_from_base, all);
  }
  return ground_shares(all, {}, map);
}

/// The walls and the ground that key scans saw.
SlamMap ground_of(const PlacedScans& keys) {
  const MapOptions options;
  SlamMap map(options, {});
  for (const PlacedScan& key : keys) {
    insert_uncounted(*key.scan->points(), key.map_from_base, options, map);
  }
  map.field.render();
  return map;
}

}  // namespace

GroundShares ground_shares(const PointScan& scan, const Pose2& map_from_base, const SlamMap& map) {
  // From a wall, three cells. Twice of it tells right loops from wrong ones less well
  // (benchmark/reports/current/LOOPS.md).
  constexpr double kOnWall = 0.15;  // [m]
  const double metres = map.field.options().reach / LikelihoodField::kFar;
  double all = 0.0;
  double mapped = 0.0;
  double off_walls = 0.0;
  for (const ScanPoint& point : scan.points) {
    const Eigen::Vector2d place = map_from_base * point.position;
    if (!place.allFinite() || !(point.weight > 0.0)) {
      continue;
    }
    const Cell cell = map.occupancy.geometry().cell_at(place);
    const bool is_off = metres * map.field.distance(cell) >= kOnWall;
    all += point.weight;
    if (!is_off || map.occupancy.is_known(cell)) {
      mapped += point.weight;
      off_walls += is_off ? point.weight : 0.0;
    }
  }
  return {all > 0.0 ? mapped / all : 0.0, mapped > 0.0 ? off_walls / mapped : 0.0};
}

double mutual_fit(const PlacedScans& here, const PlacedScans& there, double score) {
  const GroundShares on_there = shares_of_all(here, ground_of(there));
  const GroundShares on_here = shares_of_all(there, ground_of(here));
  const double on_ground = on_there.mapped > 0.0 ? std::min(1.0, score / on_there.mapped) : 0.0;
  return on_ground - on_there.off_walls - on_here.off_walls;
}

}  // namespace matchbox_slam
