#include "matchbox_slam/slam/place_finder.hpp"

namespace matchbox_slam {

void PlaceFinder::begin(const MapParts& parts, double since) {
  search_ = {};
  search_.stamp = since;
  look_among(parts);
}

std::optional<PlaceHypothesis> PlaceFinder::find(const PointScan& scan,
                                                 const Pose2& apart_from_base,
                                                 const MapParts& parts,
                                                 const EngineOptions& options) {
  return search_places(scan, apart_from_base, parts.all(), parts.here_number(), places_,
                       options.doubt, options.recovery, search_);
}

/// A robot that is not lost is looked for nowhere.
void PlaceFinder::look_among(const MapParts& parts) {
  places_.clear();
  if (parts.is_lost()) {
    places_ = searched_places(parts.all(), parts.here_number());
  }
}

}  // namespace matchbox_slam
