#include "slam/loop_search.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "map/scan_surfaces.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/free_space_violation.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matching/rendered_map.hpp"
#include "slam/scan_evidence.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kScansPerSearch = 8;  // key scans that are searched at once: a guess
// Key scans to each side of the candidate: a guess.
constexpr std::size_t kCandidateNeighbours = 10;
// Of its fine score that a place has at least in the coarse search, whose likelihoods are wider.
constexpr double kCoarseShare = 0.9;

PlacedScans in_frame(PlacedScans keys, const Pose2& frame_from_map) {
  for (PlacedScan& key : keys) {
    key.map_from_base = frame_from_map * key.map_from_base;
  }
  return keys;
}

/// The walls that key scans saw.
LikelihoodField field_of(const PlacedScans& keys, double resolution,
                         const LikelihoodFieldOptions& options) {
  std::vector<SurfaceHit> hits;
  for (const PlacedScan& key : keys) {
    const std::shared_ptr<const PointScan> points = key.scan->points();
    for (const std::vector<SurfaceHit>& some :
         {surfaces_between_hits(*points, key.map_from_base, resolution),
          surfaces_at_hits(*points, key.map_from_base)}) {
      std::copy_if(some.begin(), some.end(), std::back_inserter(hits), [](const SurfaceHit& hit) {
        return hit.position.norm() < kFarthestPoint && hit.normal.allFinite();
      });
    }
  }
  LikelihoodField field(resolution, options);
  field.update(hits, {});
  return field;
}

/// Those around one, in its frame.
PlacedScans around(const PlacedScans& keys, std::size_t candidate) {
  const std::size_t begin = candidate - std::min(candidate, kCandidateNeighbours);
  const std::size_t end = std::min(keys.size(), candidate + kCandidateNeighbours + 1);
  return in_frame({keys.begin() + static_cast<std::ptrdiff_t>(begin),
                   keys.begin() + static_cast<std::ptrdiff_t>(end)},
                  keys[candidate].map_from_base.inverse());
}

/// The newest, with the newest of all at this pose.
PlacedScans newest_at(const PlacedScans& keys, const Pose2& frame_from_newest) {
  const std::size_t count = std::min(keys.size(), kScansPerSearch);
  return in_frame({keys.end() - static_cast<std::ptrdiff_t>(count), keys.end()},
                  frame_from_newest * keys.back().map_from_base.inverse());
}

PointScan merged_newest(const PlacedScans& keys) {
  PointScan merged;
  merged.stamp = keys.back().scan->stamp();
  for (const PlacedScan& key : newest_at(keys, {})) {
    append(*key.scan->points(), key.map_from_base, merged);
  }
  return merged;
}

/// Of the first search, over all that drift may have made of the place: the walls are drawn wide,
/// for they are bent where the map has drifted.
OlsonOptions coarse_options(double sigma, const LoopOptions& options) {
  OlsonOptions coarse;
  coarse.most_look_ups = 0;
  coarse.step_xy = 0.1;
  coarse.window_xy = std::min(options.max_window, std::max(1.0, 3.0 * sigma));
  coarse.window_theta = 0.5;
  coarse.point_spacing = 0.1;
  coarse.search_floor = kCoarseShare * options.least_score;
  coarse.rival_distance = 0.5;
  coarse.least_rival = options.most_rival;
  coarse.prior_weight = 0.01;
  coarse.refinement.first_kernel = 0.3;
  coarse.refinement.last_kernel = 0.1;
  return coarse;
}

/// Of the second one, around what the first one found.
OlsonOptions fine_options() {
  OlsonOptions fine;
  fine.most_look_ups = 0;
  fine.step_xy = 0.05;
  fine.window_xy = 0.2;
  fine.window_theta = 0.04;
  fine.least_rival = 1.0;
  // A wrong loop costs more than a missed one: a few beams do not make one. With 1 cm of
  // noise this is 0.004 of the strongest direction.
  fine.refinement.weakest_facing = 30.0 * fine.refinement.weakest_facing;
  return fine;
}

/// Log odds of a place against its being none: what each of the newest key scans says of it beyond
/// what it would say of a place that is alike, less for being far from where the graph has it.
/// Pieces of a corridor are alike but for a niche or a door, and a right place is seldom
/// contradicted: the worst scans tell.
/// @param place  a map of it, in the frame of the key scan there.
/// @param sigma  [m], how well the graph knows where it is.
double log_odds_of(const PlacedScans& keys, const Pose2& place_from_newest, const SlamMap& place,
                   const Pose2& expected, double sigma) {
  // What a beam that tells says at the best wrong place around.
  constexpr double kMeanOfWrongPlace = 2.2;
  constexpr double kMinOfScan = -5.0;
  constexpr double kMapFitSigma = 0.1;  // [m], as well as maps lie to each other at best
  const Eigen::Vector2d off = place_from_newest.translation() - expected.translation();
  double log_odds = -0.5 * off.squaredNorm() / (sigma * sigma + kMapFitSigma * kMapFitSigma);
  for (const PlacedScan& key : newest_at(keys, place_from_newest)) {
    const ScanEvidence says = evidence_of(*key.scan->points(), key.map_from_base, place);
    if (says.telling >= kMinTellingShare) {
      log_odds += std::max(kMinOfScan, says.telling_mean - kMeanOfWrongPlace);
    }
  }
  return log_odds;
}

}  // namespace

std::vector<std::size_t> nearest_of_each_visit(std::vector<std::pair<double, std::size_t>> near,
                                               std::size_t gap, std::size_t most) {
  std::sort(near.begin(), near.end());
  std::vector<std::size_t> chosen;
  for (const auto& [distance, key] : near) {
    const bool is_new =
        std::none_of(chosen.begin(), chosen.end(), [&, key = key](std::size_t other) {
          return std::max(key, other) - std::min(key, other) < gap;
        });
    if (is_new && chosen.size() < most) {
      chosen.push_back(key);
    }
  }
  return chosen;
}

std::vector<LoopCandidate> loop_candidates(const PlacedScans& keys, const PathUncertainty& ways,
                                           const LoopOptions& options) {
  constexpr double kMargin = 2.0;  // [m] at which places still see the same: a guess, as the next
  constexpr std::size_t kSpread = 20;  // key scans
  constexpr std::size_t kMaxCandidates = 2;
  const Eigen::Vector2d here = keys.back().map_from_base.translation();
  const std::vector<std::size_t> within = keys_within(keys, here, options.max_window);
  const std::vector<bool> is_apart = ways.weakly_connected(within, options.max_relative_sigma);
  std::vector<std::size_t> apart;
  for (std::size_t i = 0; i < within.size(); ++i) {
    if (is_apart[i]) {
      apart.push_back(within[i]);
    }
  }
  const std::vector<double> variances = ways.variances(apart);
  std::map<std::size_t, double> sigmas;
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t i = 0; i < apart.size(); ++i) {
    const double sigma = std::sqrt(variances[i]);
    const double away = distance(keys[apart[i]], here);
    if (away < kMargin + 3.0 * sigma) {
      sigmas[apart[i]] = sigma;
      near.emplace_back(away, apart[i]);
    }
  }
  std::vector<LoopCandidate> candidates;
  for (const std::size_t key : nearest_of_each_visit(std::move(near), kSpread, kMaxCandidates)) {
    candidates.push_back({key, sigmas[key]});
  }
  return candidates;
}

std::optional<FoundLoop> find_loop(const PlacedScans& keys, const LoopCandidate& candidate,
                                   const LoopOptions& options) {
  const auto [key, sigma] = candidate;
  const PlacedScans there = around(keys, key);
  const Pose2 guess = keys[key].map_from_base.inverse() * keys.back().map_from_base;
  const PointScan scan = merged_newest(keys);
  const PlacedScans none;

  const LikelihoodField wide_field = field_of(there, 0.1, {0.1, 0.4});
  const MatchResult rough =
      OlsonMatcher(coarse_options(sigma, options))
          .match({scan, guess, covariance_of(std::max(1.0, sigma), 0.3), wide_field, none, 0});
  if (!rough.accepted() || rough.rival_share > options.most_rival) {
    return std::nullopt;
  }

  const LikelihoodField field = field_of(there, MapOptions{}.resolution, {});
  const MatchResult match =
      OlsonMatcher(fine_options())
          .match({scan, rough.map_from_base, covariance_of(1.0, 1.0), field, none, 0});
  if (!match.accepted() || !match.unconstrained_directions.empty() ||
      match.score < options.least_score) {
    return std::nullopt;
  }
  // Laid on the other side of a wall, the scan is off by its thickness.
  if (free_space_violation(scan, match.map_from_base, field) +
          share_on_other_sides(scan, match.map_from_base, field) >
      kMostViolation) {
    return std::nullopt;
  }
  const SlamMap place = rendered(there, {}, {}, MapUse::kMatched);
  FoundLoop found{key,
                  match.map_from_base,
                  match.covariance,
                  match.score,
                  rough.rival_share,
                  log_odds_of(keys, match.map_from_base, place, guess, sigma)};
  if (found.log_odds < options.decisive) {
    return std::nullopt;
  }
  found.covariance += covariance_of(0.03, 0.005);
  return found;
}

std::optional<FoundLoop> find_near(const PlacedScans& keys, std::size_t candidate) {
  const Pose2 guess = keys[candidate].map_from_base.inverse() * keys.back().map_from_base;
  const std::shared_ptr<const PointScan> points = keys.back().scan->points();
  const PosePrior prior{guess, covariance_of(0.1, 0.05)};
  const RefinedPose pose =
      refine(points->points, *keys[candidate].scan->field(), guess, prior, RefinementOptions{});
  constexpr double kLeastScore = 0.5;  // a guess
  if (!(pose.score >= kLeastScore) || !pose.unconstrained_directions.empty() ||
      !are_near(pose.map_from_base, guess, 0.1, 0.05)) {
    return std::nullopt;
  }
  return FoundLoop{
      candidate, pose.map_from_base, pose.covariance + covariance_of(0.01, 0.003), pose.score, 0.0,
      0.0};
}

}  // namespace matchbox_slam
