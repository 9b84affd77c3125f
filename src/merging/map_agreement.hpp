#pragma once

#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/slam/engine_options.hpp"

namespace matchbox_slam {

/// How many key scans of one map, of those that were taken near some of another one, were seen from
/// a place that the other map speaks against.
struct Agreement {
  std::size_t near = 0;
  std::size_t against = 0;

  [[nodiscard]] double share_against() const {
    return near > 0 ? static_cast<double>(against) / static_cast<double>(near) : 0.0;
  }
};

/// What a map says of key scans of another one, of those within 2 m of some of its own. It speaks
/// against one whose log-likelihood ratio is negative (`evidence_of`): its beams went through what
/// reflects, or ended where nothing does. That weighs each beam by what the cells on its way were
/// seen to do: glass and railings, which half of the beams pass, speak against nobody.
[[nodiscard]] Agreement agreement_of(const PlacedScans& keys, const PlacedScans& others,
                                     const EngineOptions& options);

/// Whether both maps agree, either way.
[[nodiscard]] bool do_agree(const PlacedScans& one, const PlacedScans& other,
                            const EngineOptions& options);

}  // namespace matchbox_slam
