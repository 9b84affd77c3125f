#include "merging/map_agreement.hpp"

#include <algorithm>

#include "matching/rendered_map.hpp"
#include "slam/local_map.hpp"
#include "slam/loop_search.hpp"
#include "slam/scan_evidence.hpp"

namespace matchbox_slam {
namespace {

// Where both are joined rightly up to 1.3 % of the key scans are spoken against, in five buildings;
// by how many walls they see through it would be 11.5 % at the right place in a building with a
// railing (benchmark/reports/current/MERGING.md).
constexpr double kMaxShareAgainst = 0.05;

}  // namespace

Agreement agreement_of(const PlacedScans& keys, const PlacedScans& others,
                       const EngineOptions& options) {
  constexpr double kAgreementRadius = 2.0;  // [m], a guess
  const SlamMap map = rendered(others, options.map, options.field, MapUse::kMatched);
  Agreement agreement;
  for (const PlacedScan& key : keys) {
    const Eigen::Vector2d here = key.map_from_base.translation();
    const bool is_near = std::any_of(others.begin(), others.end(), [&](const PlacedScan& other) {
      return distance(other, here) < kAgreementRadius;
    });
    if (is_near) {
      ++agreement.near;
      const double log_odds = evidence_of(*key.scan->points(), key.map_from_base, map).log_odds;
      agreement.against += log_odds < 0.0 ? 1 : 0;
    }
  }
  return agreement;
}

bool do_agree(const PlacedScans& one, const PlacedScans& other, const EngineOptions& options) {
  return agreement_of(one, other, options).share_against() <= kMaxShareAgainst &&
         agreement_of(other, one, options).share_against() <= kMaxShareAgainst;
}

}  // namespace matchbox_slam
