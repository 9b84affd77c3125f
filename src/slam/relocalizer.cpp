#include "slam/relocalizer.hpp"

#include <cstddef>

namespace matchbox_slam {

Relocalizer::Relocalizer(PlaceSearch search, const MapComponents& components)
    : search_(std::move(search)) {
  static_cast<void>(index_.grow(components.all(), components.active_number(), search_.indexed));
}

void Relocalizer::begin(double since) {
  search_ = {};
  search_.stamp = since;
  index_ = {};
}

std::optional<PlaceHypothesis> Relocalizer::find(double stamp, const Pose2& active_from_base,
                                                 const MapComponents& components,
                                                 const EngineOptions& options) {
  // Key scans with each scan: as long as a search takes, some 20 ms.
  constexpr std::size_t kAtATime = 256;
  if (!index_.is_complete()) {
    const bool is_complete = index_.grow(components.all(), components.active_number(), kAtATime);
    search_.indexed = index_.key_scans();
    if (!is_complete) {
      return std::nullopt;
    }
  }
  return search_places(stamp, active_from_base, components.all(), components.active_number(),
                       index_, options, search_);
}

}  // namespace matchbox_slam
