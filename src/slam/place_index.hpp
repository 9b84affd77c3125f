#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/slam/map_part.hpp"

namespace matchbox_slam {

/// How far it is to the nearest wall in each direction around a place, from -pi on, so that equal
/// differences are equal shares of the way: from a little elsewhere it looks nearly the same.
using PlaceLook = std::array<std::uint8_t, 72>;

/// Where a scan may have been taken, by how far it sees alone.
struct LikelyPlace {
  std::size_t part = 0;  ///< of the map
  Pose2 part_from_base;  ///< to half a metre and 0.1 rad
  double unlike = 0.0;   ///< 0: it looks just so, 1: in no direction
};

/// What each place of a map looks like, where a robot may be: on a lattice around its key scans,
/// as the walls stand now. A scan is compared with all of them, in each heading; a laser that sees
/// a part of the circle is compared in that part. A value.
class PlaceIndex {
 public:
  PlaceIndex() = default;
  /// Of all parts but one. Cost: some 20 us a place, of which there are two to four a metre.
  /// @param parts  whose fields are rendered.
  PlaceIndex(const std::vector<MapPart>& parts, std::size_t apart);

  [[nodiscard]] bool empty() const { return places_.empty(); }

  /// Up to so many, most alike first, none within a metre and 0.35 rad of a better one or of those
  /// that are known. Cost: some 1 us a place for a scan that sees all around.
  [[nodiscard]] std::vector<LikelyPlace> look_up(const PointScan& scan, std::size_t most,
                                                 std::vector<LikelyPlace> known = {}) const;

 private:
  struct Place {
    std::size_t part;
    Eigen::Vector2d at;
    PlaceLook look;
  };
  std::vector<Place> places_;
};

}  // namespace matchbox_slam
