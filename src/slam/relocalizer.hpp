#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/map_component.hpp"
#include "matchbox_slam/slam/place_search.hpp"
#include "slam/map_components.hpp"
#include "slam/place_index.hpp"

namespace matchbox_slam {

/// Looks for a lost robot with a key scan of the map that it makes meanwhile, the newest that was
/// not searched yet. Places that look alike, by the index, are searched exactly (Olson 2009), and
/// become hypotheses, which compete by evidence added up over key scans (a sequential test; Wald
/// 1945): each says for a place by how much it is better explained there than anywhere else in the
/// map, whatever went before. So rooms that are alike say nothing for any of them, whether they are
/// mapped or not. The answer is the place that is sure.
/// @param active_from_base  at the newest scan.
/// @param active            the component that the robot makes meanwhile.
[[nodiscard]] std::optional<PlaceHypothesis> search_places(
    const Pose2& active_from_base, const std::vector<MapComponent>& components, std::size_t active,
    const PlaceIndex& index, const EngineOptions& options, PlaceSearch& search);

/// Looks for a lost robot, scan by scan: where it may be, and how sure that is. A value.
class Relocalizer {
 public:
  Relocalizer() = default;
  /// Goes on with a search, as if it had never been interrupted.
  /// @param components  whose maps are drawn; the index of their places is made as far as it was.
  Relocalizer(PlaceSearch search, const MapComponents& components);

  [[nodiscard]] const PlaceSearch& search() const { return search_; }

  /// Begins anew.
  /// @param since  [s] scans before this stamp are not looked at.
  void begin(double since = 0.0);
  /// The same where the components that are searched have not changed.
  void begin_anew() {
    search_.explained.clear();
    search_.hypotheses.clear();
  }

  /// Whether a scan of this stamp [s] is looked at.
  [[nodiscard]] bool has_begun(double stamp) const { return stamp >= search_.stamp; }

  /// The component, and where in it, that the robot is found in by what it has seen, if it is. At
  /// first the places of the components are looked at, some with each scan so that none waits long;
  /// nothing is searched before all are.
  /// @param stamp  [s] of the newest scan.
  /// @param components  whose maps are drawn.
  [[nodiscard]] std::optional<PlaceHypothesis> find(double stamp, const Pose2& active_from_base,
                                                    const MapComponents& components,
                                                    const EngineOptions& options);

 private:
  PlaceSearch search_;
  PlaceIndex index_;  ///< follows from the components, and from how far it is made
};

}  // namespace matchbox_slam
