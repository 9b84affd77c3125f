#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"
#include "slam/path_uncertainty.hpp"

namespace matchbox_slam {

/// Key scans around the newest one.
struct LocalScans {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  ///< where the newest was taken
  std::size_t newest = 0;                            ///< its number
  PlacedScans belonging;                             ///< with the newest
  /// Those that are near, or will be soon, and do not lie well to the newest; by id, in their
  /// order.
  std::vector<std::uint64_t> apart;
};

/// [m] from the robot that a local map is made of key scans: a guess.
constexpr double kLocalReach = 15.0;

/// [m] from where a key scan was taken.
[[nodiscard]] double distance(const PlacedScan& key, const Eigen::Vector2d& here);

/// Numbers of the key scans that were taken less than `reach` [m] from here.
[[nodiscard]] std::vector<std::size_t> keys_within(const PlacedScans& keys,
                                                   const Eigen::Vector2d& here, double reach);

/// Whether these are the first of all key scans still, and where they were.
[[nodiscard]] bool begins_with(const PlacedScans& keys, const PlacedScans& first);

/// @param ways       from the newest.
/// @param max_sigma  [m] those that are known less well are apart.
[[nodiscard]] LocalScans local_scans(const PlacedScans& keys, const PathUncertainty& ways,
                                     double max_sigma);

/// The same without some of them.
/// @param ids  in their order.
[[nodiscard]] LocalScans without(LocalScans near, const std::vector<std::uint64_t>& ids);

/// A map of the key scans around the robot, with some from farther behind, that are known to lie
/// well to each other, for scans to be matched against where a drifted robot would else see the
/// whole map's walls twice. A value.
class LocalMap {
 public:
  LocalMap() = default;
  /// @param center  where the newest key scan of its making was taken.
  /// @param drawn   those that it shows, in the order in which they are drawn.
  /// @param taken   how many key scans there were then.
  LocalMap(const Eigen::Vector2d& center, const PlacedScans& drawn, std::size_t taken,
           const MapOptions& map_options, const LikelihoodFieldOptions& field_options);

  /// @param near  of the nearest of these: many of one place say the same.
  LocalMap(const LocalScans& near, const MapOptions& map_options,
           const LikelihoodFieldOptions& field_options);

  /// Nothing, where the whole map is to be matched against.
  [[nodiscard]] const SlamMap* map() const { return map_ ? &*map_ : nullptr; }

  [[nodiscard]] const Eigen::Vector2d& center() const { return center_; }
  /// Key scans that it shows, by id, in their order.
  [[nodiscard]] const std::vector<std::uint64_t>& drawn() const { return drawn_; }

  /// As it was when there were so many key scans.
  /// @param keys  all of them.
  [[nodiscard]] LocalMap as_of(std::size_t taken, const PlacedScans& keys,
                               const MapOptions& map_options,
                               const LikelihoodFieldOptions& field_options) const;

  /// Whether it is to be made anew for the newest key scan: others have come near since, have
  /// drifted apart, or are many.
  [[nodiscard]] bool is_due(const PlacedScans& keys) const;

  /// The same map with those of the nearest ones that it does not show: where nothing has moved,
  /// most were shown before. What it shows farther off stays. None where it would show one that
  /// lies apart by now, too many, or an older one drawn after a newer: where they differ the newer
  /// counts.
  [[nodiscard]] std::optional<LocalMap> with(const LocalScans& near,
                                             const MapOptions& map_options) const;

  /// Takes the key scans in that have come since it was made.
  void take_new(const PlacedScans& keys, const MapOptions& map_options);

  /// Some key scans are no more, none of them that it shows.
  /// @param numbers  by id: what it is now.
  /// @param gone     how many are no more, all of which it knew of.
  void renumber(const std::vector<std::size_t>& numbers, std::size_t gone);

  /// What it was made of has moved.
  void clear() { map_.reset(); }

 private:
  void draw(const PlacedScan& key, const MapOptions& map_options);

  std::optional<SlamMap> map_;
  Eigen::Vector2d center_ = Eigen::Vector2d::Zero();
  std::size_t taken_ = 0;  ///< key scans that it knows of
  std::vector<std::uint64_t> drawn_;
};

}  // namespace matchbox_slam
