#include "slam/relocalizer.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/matching/free_space_violation.hpp"
#include "matching/wide_search.hpp"
#include "slam/scan_evidence.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kMostHypotheses = 30;
constexpr std::size_t kMaxExplainedScans = 100;

/// Share of key scans that speak against a place, of two maps that are joined at the right one, at
/// most: a guess.
constexpr double kMaxShareAgainst = 0.1;

/// How far odometry may be off through a doubt: [m], [rad].
constexpr double kOdometryErrorXy = 0.5;
constexpr double kOdometryErrorTheta = 0.3;
/// Where it sees much that is not known a place is not explained, and another one may be right.
constexpr double kMinMeanEvidence = 2.0;

/// What a lost robot is looked for with.
struct Lost {
  const std::vector<MapComponent>& components;
  const MapComponent& active;  ///< the component that the robot makes meanwhile
  const EngineOptions& options;
};

/// Where a key scan may have been taken.
struct Explanation {
  std::size_t component;
  Pose2 component_from_base;
  ScanEvidence evidence;
  bool is_held;  ///< in all directions
};

bool is_near(std::size_t component_a, const Pose2& a, std::size_t component_b, const Pose2& b) {
  constexpr double kDistance = 0.3;  // [m], twice as far as a place is known to; so the next
  constexpr double kAngle = 0.15;
  return component_a == component_b && are_near(a, b, kDistance, kAngle);
}

Explanation explained_at(const PointScan& scan, std::size_t component,
                         const Pose2& component_from_base, double xy, double theta,
                         const Lost& lost) {
  const MapComponent& there = lost.components[component];
  const PlacedScans none;
  const MatchResult match = search_exactly(
      {scan, component_from_base, covariance_of(xy, theta), there.map.field, none, 0});
  return {component, match.map_from_base, evidence_of(scan, match.map_from_base, there.map),
          match.accepted() && match.unconstrained_directions.empty()};
}

/// Where it is known about as well as a search that found it says.
Explanation explained_near(const PointScan& scan, std::size_t component,
                           const Pose2& component_from_base, const Lost& lost) {
  constexpr double kSigmaXy = 0.15;
  constexpr double kSigmaTheta = 0.08;
  return explained_at(scan, component, component_from_base, kSigmaXy, kSigmaTheta, lost);
}

/// Whether a place is explained so much better than a rival that errors do not make that up.
double ahead(double log_odds, double rival) { return (1.0 - kModelErrorShare) * log_odds - rival; }

/// Robots are seldom carried away: what odometry says of the way through a doubt is about right. It
/// says nothing of components other than the one that the robot was in before, its parent.
bool is_where_odometry_says(const PlaceHypothesis& place, const Pose2& active_from_base,
                            const MapComponent& active) {
  return place.component == active.parent &&
         are_near(place.component_from_active * active_from_base,
                  active.parent_from_component * active_from_base, 2.0, 0.6);
}

/// The newest key scan that was not searched yet, of those that say something new; of one laser, as
/// another one may see little. Null where there is none.
const PlacedScan* next_key_scan(const Lost& lost, const PlaceSearch& search) {
  constexpr std::size_t kNewestSearched = 40;
  const PlacedScans& all = lost.active.key_scans.all();
  std::size_t looked_at = 0;
  for (auto key = all.rbegin(); key != all.rend() && looked_at < kNewestSearched; ++key) {
    if (key->scan->laser() != all.front().scan->laser()) {
      continue;
    }
    ++looked_at;
    const auto is_it = [&](const ExplainedScan& explained) {
      return explained.key_scan == key->scan->id();
    };
    if (std::none_of(search.explained.begin(), search.explained.end(), is_it)) {
      return &*key;
    }
  }
  return nullptr;
}

/// How well a scan fits near a place, 0 to 1, by some of its points: enough to choose what is
/// searched.
double rough_fit(const std::vector<Eigen::Vector2d>& points, const Pose2& map_from_base,
                 const LikelihoodField& field) {
  constexpr double kStep = 0.25;  // [m], within the reach of the field
  constexpr int kSteps = 3;
  constexpr double kTurn = 0.04;  // [rad]
  constexpr int kTurns = 1;
  int best = 0;
  for (int turn = -kTurns; turn <= kTurns; ++turn) {
    const double theta = map_from_base.theta + kTurn * turn;
    const Eigen::Rotation2Dd rotation(theta);
    std::vector<Eigen::Vector2d> turned;
    turned.reserve(points.size());
    for (const Eigen::Vector2d& point : points) {
      turned.emplace_back(map_from_base.translation() + rotation * point);
    }
    for (int y = -kSteps; y <= kSteps; ++y) {
      for (int x = -kSteps; x <= kSteps; ++x) {
        const Eigen::Vector2d moved(kStep * x, kStep * y);
        int near = 0;
        for (const Eigen::Vector2d& point : turned) {
          near += LikelihoodField::kFar - field.distance(field.geometry().cell_at(point + moved));
        }
        best = std::max(best, near);
      }
    }
  }
  return static_cast<double>(best) /
         (LikelihoodField::kFar * static_cast<double>(std::max<std::size_t>(1, points.size())));
}

/// Of the places that look most alike, those where the scan fits best.
std::vector<LikelyPlace> places_to_search(const PointScan& scan, const Lost& lost,
                                          const PlaceIndex& index, std::vector<LikelyPlace> known) {
  constexpr std::size_t kCandidateFactor = 8;
  constexpr std::size_t kPoints = 40;
  const auto most = static_cast<std::size_t>(lost.options.recovery.places);
  std::vector<LikelyPlace> places = index.look_up(scan, kCandidateFactor * most, std::move(known));
  std::vector<Eigen::Vector2d> points;
  const std::size_t stride = scan.points.size() / kPoints + 1;
  for (std::size_t i = stride / 2; i < scan.points.size(); i += stride) {
    if (scan.points[i].position.norm() < kFarthestPoint) {
      points.push_back(scan.points[i].position);
    }
  }
  for (LikelyPlace& place : places) {
    place.unlike = 1.0 - rough_fit(points, place.component_from_base,
                                   lost.components[place.component].map.field);
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const auto& a, const auto& b) { return a.unlike < b.unlike; });
  places.resize(std::min(places.size(), most));
  return places;
}

/// By exact search at places that look alike.
std::vector<Explanation> explained_anywhere(const PointScan& scan, std::vector<LikelyPlace> known,
                                            const Lost& lost, const PlaceIndex& index) {
  constexpr double kSigmaXy = 0.5;      // [m], half of what is between places of the index
  constexpr double kSigmaTheta = 0.08;  // [rad], twice as far as it knows a heading
  std::vector<Explanation> found;
  for (const LikelyPlace& place : places_to_search(scan, lost, index, std::move(known))) {
    found.push_back(explained_at(scan, place.component, place.component_from_base, kSigmaXy,
                                 kSigmaTheta, lost));
  }
  return found;
}

/// All that explains a key scan: first where the hypotheses have it, in their order.
std::vector<Explanation> explanations_of(const PointScan& scan, const Pose2& active_from_base,
                                         const Lost& lost, const PlaceIndex& index,
                                         const std::vector<PlaceHypothesis>& hypotheses) {
  std::vector<Explanation> found;
  std::vector<LikelyPlace> known;
  for (const PlaceHypothesis& place : hypotheses) {
    found.push_back(explained_near(scan, place.component,
                                   place.component_from_active * active_from_base, lost));
    known.push_back({place.component, found.back().component_from_base});
  }
  const std::size_t parent = lost.active.parent;
  if (&lost.components[parent] != &lost.active) {
    found.push_back(explained_at(scan, parent, lost.active.parent_from_component * active_from_base,
                                 kOdometryErrorXy, kOdometryErrorTheta, lost));
  }
  for (const Explanation& one : explained_anywhere(scan, std::move(known), lost, index)) {
    found.push_back(one);
  }
  return found;
}

ExplainedScan best_of(const std::vector<Explanation>& explanations, std::uint64_t key_scan) {
  ExplainedScan explained{key_scan, 0, {}, 0.0, 0.0};
  for (const Explanation& one : explanations) {
    if (one.evidence.log_odds > explained.best) {
      explained.best = one.evidence.log_odds;
      explained.component = one.component;
      explained.component_from_base = one.component_from_base;
    }
  }
  for (const Explanation& one : explanations) {
    if (!is_near(one.component, one.component_from_base, explained.component,
                 explained.component_from_base)) {
      explained.elsewhere = std::max(explained.elsewhere, one.evidence.log_odds);
    }
  }
  return explained;
}

/// Log odds of a place against somewhere unknown, by one scan. What is not mapped looks like what
/// is as often as places of the map look like each other: that bounds what it says for a place.
/// @param explained  that scan.
double odds_of(const Explanation& here, const ExplainedScan& explained, const PlaceSearch& search) {
  constexpr double kPriorAlike = 0.1;  // of one, before any was looked at
  const double elsewhere = odds_of_elsewhere(here.evidence);
  if (elsewhere >= 0.0) {
    return -elsewhere;
  }
  if (!here.is_held || here.evidence.mean < kMinMeanEvidence) {
    return 0.0;
  }
  const bool is_best = is_near(here.component, here.component_from_base, explained.component,
                               explained.component_from_base);
  const double rival = std::max(0.0, is_best ? explained.elsewhere : explained.best);
  const double most =
      std::min(kMostOfScan, std::log((1.0 + search.sampled) / (kPriorAlike + search.alike)));
  return std::clamp(ahead(here.evidence.log_odds, rival), 0.0, most);
}

/// Looks whether a key scan of the map might as well have been taken elsewhere in it.
void sample(const Lost& lost, const PlaceIndex& index, PlaceSearch& search) {
  constexpr int kMaxSampledScans = 20;
  constexpr double kGolden = 0.6180339887498949;  // so that they are spread evenly at any time
  constexpr double kSamePlaceRadius = 1.0;        // [m]
  const std::size_t component = lost.active.parent;
  const PlacedScans& keys = lost.components[component].key_scans.all();
  if (search.sampled >= kMaxSampledScans || keys.empty() ||
      &lost.components[component] == &lost.active) {
    return;
  }
  const double share = std::fmod(kGolden * (search.sampled + 1), 1.0);
  const PlacedScan& key = keys[static_cast<std::size_t>(share * static_cast<double>(keys.size()))];
  const std::shared_ptr<const PointScan> scan = key.scan->points();
  const double here =
      evidence_of(*scan, key.map_from_base, lost.components[component].map).log_odds;
  const auto is_as_well = [&](const Explanation& there) {
    const Eigen::Vector3d apart = difference(there.component_from_base, key.map_from_base);
    return (there.component != component || apart.head<2>().norm() > kSamePlaceRadius) &&
           there.evidence.mean >= kMinMeanEvidence && ahead(here, there.evidence.log_odds) < 0.0;
  };
  const std::vector<Explanation> found =
      explained_anywhere(*scan, {{component, key.map_from_base, 0.0}}, lost, index);
  search.alike += std::any_of(found.begin(), found.end(), is_as_well) ? 1 : 0;
  ++search.sampled;
}

/// What key scans that were searched before say of a place that is new.
double odds_of_way(const PlaceHypothesis& place, const Lost& lost, const PlaceSearch& search) {
  constexpr std::size_t kPlacesAsked = 6;
  double log_odds = 0.0;
  std::size_t asked = 0;
  for (auto explained = search.explained.rbegin();
       explained != search.explained.rend() && asked < kPlacesAsked; ++explained, ++asked) {
    const PlacedScan& key = lost.active.key_scans.all()[explained->key_scan];
    const Explanation here = explained_near(*key.scan->points(), place.component,
                                            place.component_from_active * key.map_from_base, lost);
    log_odds += odds_of(here, *explained, search);
  }
  return log_odds;
}

/// What was drawn in the active component may have been taken back.
void forget_scans_that_are_no_more(const KeyScans& keys, PlaceSearch& search) {
  std::vector<ExplainedScan>& all = search.explained;
  const auto is_gone = [&](const ExplainedScan& one) { return one.key_scan >= keys.size(); };
  all.erase(std::remove_if(all.begin(), all.end(), is_gone), all.end());
}

/// What a hypothesis, or a new place, is after a key scan, if it is worth following.
std::optional<PlaceHypothesis> weighed(const PlaceHypothesis* before, const Explanation& here,
                                       const ExplainedScan& explained, const PlacedScan& key,
                                       const Lost& lost, const PlaceSearch& search) {
  PlaceHypothesis place =
      before != nullptr ? *before : PlaceHypothesis{here.component, {}, 0.0, 0.0};
  const double says = odds_of(here, explained, search);
  place.log_odds += says;
  place.behind += std::clamp(explained.best - here.evidence.log_odds, 0.0, kMostOfScan);
  const bool is_refuted = says < -1.0 && place.log_odds < -lost.options.hypotheses.decisive;
  const bool is_agreed_with =
      here.evidence.telling >= kMinTellingShare && odds_of_elsewhere(here.evidence) < 0.0;
  if (before != nullptr ? is_refuted : !is_agreed_with) {
    return std::nullopt;
  }
  if (here.is_held || before == nullptr) {
    place.component_from_active = here.component_from_base * key.map_from_base.inverse();
  }
  return place;
}

bool has_copy(const std::vector<PlaceHypothesis>& places, const PlaceHypothesis& place,
              const Pose2& active_from_base) {
  return std::any_of(places.begin(), places.end(), [&](const PlaceHypothesis& other) {
    return is_near(place.component, place.component_from_active * active_from_base, other.component,
                   other.component_from_active * active_from_base);
  });
}

void weigh(const PlacedScan& key, const Lost& lost, const PlaceIndex& index, PlaceSearch& search) {
  std::vector<PlaceHypothesis>& hypotheses = search.hypotheses;
  const std::vector<Explanation> found =
      explanations_of(*key.scan->points(), key.map_from_base, lost, index, hypotheses);
  const ExplainedScan explained = best_of(found, key.scan->id());
  std::vector<PlaceHypothesis> kept;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const bool is_new = i >= hypotheses.size();
    std::optional<PlaceHypothesis> place =
        weighed(is_new ? nullptr : &hypotheses[i], found[i], explained, key, lost, search);
    if (!place || has_copy(kept, *place, key.map_from_base)) {
      continue;
    }
    if (is_new && place->log_odds > 0.0) {
      place->log_odds += odds_of_way(*place, lost, search);
    }
    kept.push_back(*place);
  }
  std::stable_sort(kept.begin(), kept.end(),
                   [](const auto& a, const auto& b) { return a.log_odds > b.log_odds; });
  kept.resize(std::min(kept.size(), kMostHypotheses));
  hypotheses = std::move(kept);
  search.explained.push_back(explained);
  if (search.explained.size() > kMaxExplainedScans) {
    search.explained.erase(search.explained.begin());
  }
}

/// Whether a scan would rather be elsewhere, as its beams go through walls there: not through a
/// railing, which stops half of them, and not for what is new or only noisy.
bool speaks_against(const PointScan& scan, const Pose2& map_from_base,
                    const MapComponent& component) {
  return free_space_violation(scan, map_from_base, component.map.field) > kMostViolation &&
         odds_of_elsewhere(evidence_of(scan, map_from_base, component.map)) >= 0.0;
}

/// Share of key scans of one component, of those that lie within another, that speak against that:
/// of so many of them, spread evenly, that no scan waits long.
double share_against(const PlacedScans& keys, const MapComponent& other,
                     const Pose2& other_from_component) {
  constexpr std::size_t kMaxCheckedScans = 30;  // a guess: half and double were not tried
  const CellBox known = other.map.occupancy.known_bounds();
  PlacedScans within;
  for (const PlacedScan& key : keys) {
    const Pose2 other_from_base = other_from_component * key.map_from_base;
    if (known.contains(other.map.occupancy.geometry().cell_at(other_from_base.translation()))) {
      within.push_back({key.scan, other_from_base});
    }
  }
  const std::size_t stride = within.size() / kMaxCheckedScans + 1;
  std::size_t looked_at = 0;
  std::size_t against = 0;
  for (std::size_t i = 0; i < within.size(); i += stride) {
    against += speaks_against(*within[i].scan->points(), within[i].map_from_base, other) ? 1 : 0;
    ++looked_at;
  }
  return looked_at > 0 ? static_cast<double>(against) / static_cast<double>(looked_at) : 0.0;
}

/// Where rooms are alike, what lies around them tells: how many key scans of either component speak
/// against the place, joined to the other as it has it.
double share_against(const Lost& lost, const PlaceHypothesis& place) {
  const MapComponent& there = lost.components[place.component];
  return std::max(
      share_against(lost.active.key_scans.all(), there, place.component_from_active),
      share_against(there.key_scans.all(), lost.active, place.component_from_active.inverse()));
}

/// The first place, if it is the right one; where it cannot be, it is one no more.
std::optional<PlaceHypothesis> take_first(const Lost& lost,
                                          std::vector<PlaceHypothesis>& hypotheses) {
  constexpr double kMinRefutingShare = 0.3;
  const PlaceHypothesis best = hypotheses.front();
  const auto is_rival = [&](const PlaceHypothesis& other) {
    return other.behind - best.behind < lost.options.hypotheses.decisive;
  };
  if (std::any_of(hypotheses.begin() + 1, hypotheses.end(), is_rival)) {
    return std::nullopt;
  }
  const double against = share_against(lost, best);
  if (against > kMinRefutingShare) {
    hypotheses.erase(hypotheses.begin());
  }
  return against <= kMaxShareAgainst ? std::optional(best) : std::nullopt;
}

}  // namespace

std::optional<PlaceHypothesis> search_places(const Pose2& active_from_base,
                                             const std::vector<MapComponent>& components,
                                             std::size_t active, const PlaceIndex& index,
                                             const EngineOptions& options, PlaceSearch& search) {
  const Lost lost{components, components[active], options};
  forget_scans_that_are_no_more(lost.active.key_scans, search);
  sample(lost, index, search);
  const PlacedScan* key = next_key_scan(lost, search);
  if (key == nullptr) {
    return std::nullopt;
  }
  weigh(*key, lost, index, search);
  if (search.hypotheses.empty()) {
    return std::nullopt;
  }
  const PlaceHypothesis& best = search.hypotheses.front();
  const double wanted =
      options.recovery.sure - (is_where_odometry_says(best, active_from_base, lost.active)
                                   ? options.hypotheses.decisive
                                   : 0.0);
  return best.log_odds < wanted ? std::nullopt : take_first(lost, search.hypotheses);
}

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
  constexpr std::size_t kIndexedPerScan = 256;
  if (!index_.is_complete()) {
    const bool is_complete =
        index_.grow(components.all(), components.active_number(), kIndexedPerScan);
    search_.indexed = index_.key_scans();
    if (!is_complete) {
      return std::nullopt;
    }
  }
  constexpr double kJitter = 0.1;  // share of an interval that is as long as that between scans
  if (stamp - search_.stamp < (1.0 - kJitter) * options.recovery.interval) {
    return std::nullopt;
  }
  search_.stamp = stamp;
  return search_places(active_from_base, components.all(), components.active_number(), index_,
                       options, search_);
}

}  // namespace matchbox_slam
