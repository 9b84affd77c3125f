#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/slam/map_component.hpp"
#include "slam/scan_profile.hpp"

namespace matchbox_slam {

/// How far it is to the nearest wall in each direction around a place, from -pi on, so that equal
/// differences are equal shares of the way: from a little elsewhere it looks nearly the same.
using PlaceLook = std::array<std::uint8_t, kSectors>;

/// The same in every other direction.
using HalfLook = std::array<std::uint8_t, kSectors / 2>;

/// Row and column.
using LatticePoint = std::pair<int, int>;

/// Where a scan may have been taken, by how far it sees alone.
struct LikelyPlace {
  std::size_t component = 0;  ///< of the map
  Pose2 component_from_base;  ///< to half a metre and 0.1 rad
  double unlike = 0.0;        ///< 0: it looks just so, 1: in no direction
};

/// What each place of a map looks like, where a robot may be: on a lattice around its key scans,
/// as the walls stand now. A scan is compared with all of them, in each heading; a laser that sees
/// a part of the circle is compared in that part. A value.
class PlaceIndex {
 public:
  /// Of nothing yet: to be grown.
  PlaceIndex() = default;
  /// Of all components but one, at once.
  /// @param components  whose fields are rendered.
  PlaceIndex(const std::vector<MapComponent>& components, std::size_t active);

  /// Takes in what lies around that many more key scans of the same components, in their order.
  /// Whether that is all: before, nothing is to be looked up, as the right place may be missing.
  /// The index is the same in however many steps it is made. Cost: some 80 us a key scan.
  [[nodiscard]] bool grow(const std::vector<MapComponent>& components, std::size_t active,
                          std::size_t key_scans);

  [[nodiscard]] bool is_complete() const { return is_complete_; }
  /// Key scans around which it knows the places.
  [[nodiscard]] std::size_t key_scans() const { return taken_; }

  /// Up to so many, most alike first, none within a metre and 0.35 rad of a better one or of those
  /// that are known. Cost: some 0.2 us a place for a scan that sees all around.
  [[nodiscard]] std::vector<LikelyPlace> look_up(const PointScan& scan, std::size_t most,
                                                 std::vector<LikelyPlace> known = {}) const;

 private:
  struct Place {
    std::size_t component;
    LatticePoint at;
    PlaceLook look;
  };

  void take_around(const Eigen::Vector2d& from, const LikelihoodField& field);
  void finish();

  std::vector<Place> places_;
  std::vector<HalfLook> halves_;  ///< of each place, when it is complete
  // While it grows.
  std::size_t component_ = 0;       ///< that the next key scan is of
  std::size_t next_ = 0;            ///< key scan of that component
  std::size_t taken_ = 0;           ///< key scans of all components
  std::set<LatticePoint> lattice_;  ///< of the component's places
  bool is_complete_ = false;
};

}  // namespace matchbox_slam
