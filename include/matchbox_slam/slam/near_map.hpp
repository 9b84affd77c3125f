#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"

namespace matchbox_slam {

/// The map that key scans make, in their order.
[[nodiscard]] SlamMap rendered(const PlacedScans& keys, const MapOptions& map_options,
                               const LikelihoodFieldOptions& field_options);

/// A map of the key scans around the robot that are known to lie well to each other, for scans to
/// be matched against where a drifted robot would else see the whole map's walls twice. A value.
class NearMap {
 public:
  NearMap() = default;
  /// @param center  where it was made; it is made anew farther from there.
  NearMap(SlamMap map, const Eigen::Vector2d& center) : map_(std::move(map)), center_(center) {}

  /// Nothing, where the whole map is to be matched against.
  [[nodiscard]] const SlamMap* map() const { return map_ ? &*map_ : nullptr; }

  [[nodiscard]] const Eigen::Vector2d& center() const { return center_; }

  /// Takes the newest key scan, once it is inserted into the whole map, and decides.
  /// @param is_apart     whether each key scan does not belong with the newest.
  /// @param is_outdated  the whole map is not to be matched against anyway.
  void add(const PlacedScans& keys, const std::vector<bool>& is_apart, bool is_outdated,
           const MapOptions& map_options, const LikelihoodFieldOptions& field_options);

  /// What it was made of has moved.
  void clear() { map_.reset(); }

 private:
  std::optional<SlamMap> map_;
  Eigen::Vector2d center_ = Eigen::Vector2d::Zero();
};

}  // namespace matchbox_slam
