#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "slam/map_parts.hpp"
#include "slam/recovery.hpp"

namespace matchbox_slam {

/// From one scan to the next.
struct SearchStep {
  double seconds = 0.0;
  double way = 0.0;  ///< [m]
};

/// Looks for a lost robot, scan by scan: which places are searched, and how far that is. A value.
class Relocalizer {
 public:
  Relocalizer() = default;
  /// Goes on with a search.
  Relocalizer(PlaceSearch search, const MapParts& parts) : search_(std::move(search)) {
    look_among(parts);
  }

  [[nodiscard]] const PlaceSearch& search() const { return search_; }

  /// Begins anew.
  /// @param since  [s] scans before this stamp are not looked at.
  void begin(const MapParts& parts, double since = 0.0);

  /// Whether a scan of this stamp [s] is looked at.
  [[nodiscard]] bool has_begun(double stamp) const { return stamp >= search_.stamp; }

  /// The part, and where in it, that the robot is found in by its newest scan, if it is.
  /// @param step  since the scan before: the longer it is, the more is searched with this one.
  [[nodiscard]] std::optional<PlaceHypothesis> find(const PointScan& scan,
                                                    const Pose2& apart_from_base,
                                                    const SearchStep& step, const MapParts& parts,
                                                    const EngineOptions& options);

 private:
  void look_among(const MapParts& parts);

  PlaceSearch search_;
  std::vector<SearchedPlace> places_;  ///< follows from the parts
};

}  // namespace matchbox_slam
