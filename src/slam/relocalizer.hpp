#pragma once

#include <optional>
#include <utility>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "slam/map_components.hpp"
#include "slam/place_index.hpp"
#include "slam/recovery.hpp"

namespace matchbox_slam {

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
