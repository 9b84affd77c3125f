#pragma once

#include "matchbox_slam/map/occupancy_grid.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"

namespace matchbox_slam {

/// A map as coarse as a movie shows it, drawn from key scans as far as these have changed since it
/// was drawn last: the run's own may have to be rendered whole, which takes twenty times as long.
class MovieMap {
 public:
  /// Most cells of the map's width and height; where there are more, cells become twice as large.
  static constexpr int kMostCells = 760;

  /// Draws what is new. Begins anew where a key scan is gone, or has moved by a cell.
  void draw(const PlacedScans& keys, double finest_resolution);

  [[nodiscard]] const OccupancyGrid& grid() const { return grid_; }
  /// Times that cells have become twice as large.
  [[nodiscard]] int level() const { return level_; }

 private:
  [[nodiscard]] bool is_outdated(const PlacedScans& keys) const;
  [[nodiscard]] bool is_too_large() const;
  void begin();
  void add(const PlacedScan& key);

  MapOptions options_;
  int level_ = 0;
  OccupancyGrid grid_{options_.resolution};
  PlacedScans drawn_;
  InsertionMemory memory_;
};

}  // namespace matchbox_slam
