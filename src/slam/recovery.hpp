#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/slam/map_part.hpp"
#include "matchbox_slam/slam/place_search.hpp"

namespace matchbox_slam {

/// Share of key scans that see through walls, of two maps that are joined at the right place, at
/// most. Of 17 of 18 right places none of the key scans does, of the other one up to 24 %: seen at
/// a grazing angle from afar, an open door cannot be told from wall. Of wrong places 0 to 100 %.
constexpr double kMostThroughWalls = 0.1;

/// Where key scans are that are searched.
struct SearchedPlace {
  std::size_t part;
  PlacedScan key;
};

/// The key scans of all parts but one that are worth searching: those that see something else than
/// the others.
[[nodiscard]] std::vector<SearchedPlace> searched_places(const std::vector<MapPart>& parts,
                                                         std::size_t apart);

/// Looks for a lost robot with its newest scan. Each time a few key scans are searched, with no
/// idea of where the scan was taken (Censi, Iocchi and Grisetti 2005); places where it fits become
/// hypotheses, which key scans of the way there and the next scans confirm or refute by exact
/// search (Olson 2009). The answer is the one place that is left: several scans matched there and
/// hardly one elsewhere, and, unless it is near where odometry says, all key scans were searched.
/// @param apart   part of the map that the robot makes meanwhile.
/// @param places  as of `searched_places`.
[[nodiscard]] std::optional<PlaceHypothesis> search_places(
    const PointScan& scan, const Pose2& apart_from_base, const std::vector<MapPart>& parts,
    std::size_t apart, const std::vector<SearchedPlace>& places, const RecoveryOptions& options,
    PlaceSearch& search);

}  // namespace matchbox_slam
