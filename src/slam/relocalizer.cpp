#include "slam/relocalizer.hpp"

namespace matchbox_slam {

void Relocalizer::begin(double since) {
  search_ = {};
  search_.stamp = since;
  index_.reset();
}

std::optional<PlaceHypothesis> Relocalizer::find(double stamp, const Pose2& apart_from_base,
                                                 const MapParts& parts,
                                                 const EngineOptions& options) {
  if (!index_) {
    index_.emplace(parts.all(), parts.here_number());
  }
  return search_places(stamp, apart_from_base, parts.all(), parts.here_number(), *index_, options,
                       search_);
}

}  // namespace matchbox_slam
