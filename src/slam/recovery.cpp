#include "matchbox_slam/slam/recovery.hpp"

#include <algorithm>
#include <cmath>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/matching/contradiction.hpp"
#include "matching/hough/hough_search.hpp"
#include "matching/hough/relocalise.hpp"

namespace matchbox_slam {
namespace {

// Guesses, tried on six drives with faults (benchmark/reports/2026-11-23/CONSTANTS.md): half of the
// first two finds one carried robot 0.6 s later, half or double of the others changes no byte
// there. How well a place is known before a scan is matched there: [m], [rad].
constexpr double kPlaceXy = 0.15;
constexpr double kPlaceTheta = 0.08;

constexpr std::size_t kMostHypotheses = 24;
constexpr std::size_t kChecksAtATime = 4;
constexpr std::size_t kNearEach = 5;  // key scans searched

bool is_near(const PlaceHypothesis& a, const PlaceHypothesis& b) {
  // Twice as far as a place is known to. Half or double changes no byte (CONSTANTS.md).
  constexpr double kDistance = 0.3;  // [m]
  constexpr double kAngle = 0.15;    // [rad]
  // Where both put the robot: the frames' origins may be far off.
  const Pose2 apart =
      (a.part_from_apart * a.apart_from_base).inverse() * b.part_from_apart * a.apart_from_base;
  return a.part == b.part && apart.translation().norm() < kDistance &&
         std::abs(apart.theta) < kAngle;
}

MatchResult match_at(const PointScan& scan, const Pose2& part_from_base, double xy, double theta,
                     const MapPart& part) {
  const PlacedScans none;
  return search_exactly({scan, part_from_base, covariance_of(xy, theta), part.map.field, none, 0},
                        part.map.occupancy);
}

/// A place is refuted where the scan clearly contradicts it; one where little is mapped says
/// nothing.
enum class Verdict { kConfirmed, kOpen, kRefuted };

/// By half as much again as what makes a doubt: there it is only looked at again, here a place is
/// dropped for good.
bool is_refuted(double contradiction, const DoubtOptions& doubt) {
  return contradiction > 1.5 * doubt.contradiction;
}

Verdict judge(const MatchResult& match, bool is_near, const DoubtOptions& doubt,
              const RecoveryOptions& options) {
  // What a corridor does not hold fits all along it: there odometry has to tell.
  const bool is_held = is_near || match.unconstrained_directions.empty();
  if (is_convincing(match, doubt) && is_held && (is_near || match.score >= options.least_score)) {
    return Verdict::kConfirmed;
  }
  return is_refuted(match.contradiction, doubt) ? Verdict::kRefuted : Verdict::kOpen;
}

/// Robots are seldom carried away: what odometry says of the way through a doubt is about right. It
/// says nothing of parts other than the one that the robot left.
bool is_where_odometry_says(const PlaceHypothesis& place, const MapPart& apart) {
  // Guesses. With half nothing changes, with double one carried robot is found 6 s sooner
  // (CONSTANTS.md), by fewer confirmations.
  constexpr double kDistance = 2.0;  // [m]
  constexpr double kAngle = 0.6;     // [rad]
  const Eigen::Vector3d off = difference(place.part_from_apart * place.apart_from_base,
                                         apart.left_from_here * place.apart_from_base);
  return place.part == apart.left && off.head<2>().norm() <= kDistance &&
         std::abs(off.z()) <= kAngle;
}

void drop_copies(std::vector<PlaceHypothesis>& hypotheses) {
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const auto& a, const auto& b) { return a.confirmations > b.confirmations; });
  std::vector<PlaceHypothesis> kept;
  for (const PlaceHypothesis& hypothesis : hypotheses) {
    const bool is_new = std::none_of(kept.begin(), kept.end(), [&](const PlaceHypothesis& other) {
      return is_near(other, hypothesis);
    });
    if (is_new && kept.size() < kMostHypotheses) {
      kept.push_back(hypothesis);
    }
  }
  hypotheses = std::move(kept);
}

/// Looks again at the hypotheses that were not looked at for some way, a few at a time.
void check_hypotheses(const PointScan& scan, const Pose2& apart_from_base,
                      const std::vector<MapPart>& parts, std::size_t apart,
                      const DoubtOptions& doubt, const RecoveryOptions& options,
                      std::vector<PlaceHypothesis>& hypotheses) {
  std::vector<PlaceHypothesis> kept;
  std::size_t checks = 0;
  for (PlaceHypothesis& hypothesis : hypotheses) {
    const Pose2 moved = hypothesis.apart_from_base.inverse() * apart_from_base;
    const bool is_due =
        moved.translation().norm() >= options.distance || std::abs(moved.theta) >= options.distance;
    if (is_due && checks < kChecksAtATime) {
      ++checks;
      const MatchResult match = match_at(scan, hypothesis.part_from_apart * apart_from_base,
                                         kPlaceXy, kPlaceTheta, parts[hypothesis.part]);
      const Verdict verdict =
          judge(match, is_where_odometry_says(hypothesis, parts[apart]), doubt, options);
      if (verdict == Verdict::kRefuted) {
        continue;
      }
      hypothesis.apart_from_base = apart_from_base;
      if (verdict == Verdict::kConfirmed) {
        ++hypothesis.confirmations;
        hypothesis.part_from_apart = match.map_from_base * apart_from_base.inverse();
      }
    }
    kept.push_back(hypothesis);
  }
  hypotheses = std::move(kept);
}

/// The places around a key scan where the scan fits.
std::vector<PlaceHypothesis> find_around(const PointScan& scan, const SearchedScan& searched,
                                         const Pose2& apart_from_base, const SearchedPlace& place,
                                         const std::vector<MapPart>& parts, std::size_t apart,
                                         const DoubtOptions& doubt,
                                         const RecoveryOptions& options) {
  const MapPart& part = parts[place.part];
  constexpr std::size_t kTries = 3;  // a guess; half or double changes no byte (CONSTANTS.md)
  std::vector<PlaceHypothesis> found;
  for (const RankedPose& pose : search_anywhere(searched, place.key, HoughOptions{}, kTries)) {
    // Cheap, and most are none: the walls of the part, which are more than the key scan's.
    if (is_refuted(contradiction(scan, pose.map_from_base, part.map.field), doubt)) {
      continue;
    }
    const MatchResult match = match_at(scan, pose.map_from_base, kPlaceXy, kPlaceTheta, part);
    const PlaceHypothesis hypothesis{place.part, match.map_from_base * apart_from_base.inverse(), 1,
                                     apart_from_base};
    const bool is_near = is_where_odometry_says(hypothesis, parts[apart]);
    if (judge(match, is_near, doubt, options) == Verdict::kConfirmed) {
      found.push_back(hypothesis);
    }
  }
  return found;
}

/// Looks where odometry says that the robot is in the part that it left.
void look_near(const PointScan& scan, const Pose2& apart_from_base,
               const std::vector<MapPart>& parts, std::size_t apart, const DoubtOptions& doubt,
               const RecoveryOptions& options, PlaceSearch& search) {
  constexpr double kTheta = 0.3;  // [rad], a guess; half or double changes no byte (CONSTANTS.md)
  const std::size_t left = parts[apart].left;
  if (left == apart) {
    return;
  }
  const MatchResult match = match_at(scan, parts[apart].left_from_here * apart_from_base,
                                     doubt.look_xy, kTheta, parts[left]);
  if (judge(match, true, doubt, options) == Verdict::kConfirmed) {
    search.hypotheses.push_back(
        {left, match.map_from_base * apart_from_base.inverse(), 1, apart_from_base});
  }
}

void add_hypotheses(const PointScan& scan, const Pose2& apart_from_base,
                    const std::vector<MapPart>& parts, std::size_t apart,
                    const std::vector<SearchedPlace>& places, const DoubtOptions& doubt,
                    const RecoveryOptions& options, PlaceSearch& search) {
  const SearchedScan searched(scan, HoughOptions{}.alignment.point_spacing);
  const std::size_t count = std::min(static_cast<std::size_t>(options.key_scans), places.size());
  for (std::size_t i = 0; i < count; ++i) {
    search.next = std::min(search.next, places.size() - 1);
    const SearchedPlace& place = places[search.next++];
    const std::vector<PlaceHypothesis> found =
        find_around(scan, searched, apart_from_base, place, parts, apart, doubt, options);
    search.hypotheses.insert(search.hypotheses.end(), found.begin(), found.end());
    if (search.next == places.size()) {
      search.next = 0;
      search.complete = true;
    }
  }
}

/// Share of key scans of one part, of those that lie within another, that would see through walls
/// of that: of so many of them, spread evenly, that no scan waits long.
double share_through_walls(const PlacedScans& keys, const MapPart& other,
                           const Pose2& other_from_part, const DoubtOptions& doubt) {
  constexpr std::size_t kMost = 30;  // a guess: half and double were not tried
  const CellBox known = other.map.occupancy.known_bounds();
  PlacedScans within;
  for (const PlacedScan& key : keys) {
    const Pose2 other_from_base = other_from_part * key.map_from_base;
    if (known.contains(other.map.occupancy.geometry().cell_at(other_from_base.translation()))) {
      within.push_back({key.scan, other_from_base});
    }
  }
  const std::size_t stride = within.size() / kMost + 1;
  std::size_t looked_at = 0;
  std::size_t through = 0;
  for (std::size_t i = 0; i < within.size(); i += stride) {
    const double against =
        contradiction(*within[i].scan->points(), within[i].map_from_base, other.map.field);
    through += against > doubt.contradiction ? 1 : 0;
    ++looked_at;
  }
  return looked_at > 0 ? static_cast<double>(through) / static_cast<double>(looked_at) : 0.0;
}

/// Where rooms are alike, what lies around them tells: no more than a few key scans of either part
/// see through walls of the other, joined as the place has it.
bool fits_whole(const PlaceHypothesis& place, const std::vector<MapPart>& parts, std::size_t apart,
                const std::vector<SearchedPlace>& places, const DoubtOptions& doubt) {
  // Of wrong places 87 to 100 % of the key scans do, of right ones none, in all drives looked at.
  // Half or double changes no byte (CONSTANTS.md).
  constexpr double kFew = 0.1;
  PlacedScans there;
  for (const SearchedPlace& searched : places) {
    if (searched.part == place.part) {
      there.push_back(searched.key);
    }
  }
  return share_through_walls(spread_out(parts[apart].key_scans.all()), parts[place.part],
                             place.part_from_apart, doubt) <= kFew &&
         share_through_walls(there, parts[apart], place.part_from_apart.inverse(), doubt) <= kFew;
}

}  // namespace

std::vector<SearchedPlace> searched_places(const std::vector<MapPart>& parts, std::size_t apart) {
  std::vector<SearchedPlace> places;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i != apart) {
      for (const PlacedScan& key : spread_out(parts[i].key_scans.all())) {
        places.push_back({i, key});
      }
    }
  }
  return places;
}

std::optional<PlaceHypothesis> search_places(const PointScan& scan, const Pose2& apart_from_base,
                                             const std::vector<MapPart>& parts, std::size_t apart,
                                             const std::vector<SearchedPlace>& places,
                                             const DoubtOptions& doubt,
                                             const RecoveryOptions& options, PlaceSearch& search) {
  constexpr double kJitter = 0.1;  // share of an interval that is as long as that between scans
  if (scan.stamp - search.stamp < (1.0 - kJitter) * options.interval) {
    return std::nullopt;
  }
  search.stamp = scan.stamp;
  check_hypotheses(scan, apart_from_base, parts, apart, doubt, options, search.hypotheses);
  if (search.next % kNearEach == 0) {
    look_near(scan, apart_from_base, parts, apart, doubt, options, search);
  }
  add_hypotheses(scan, apart_from_base, parts, apart, places, doubt, options, search);
  drop_copies(search.hypotheses);
  if (search.hypotheses.empty()) {
    return std::nullopt;
  }
  const PlaceHypothesis& best = search.hypotheses.front();
  const int next = search.hypotheses.size() > 1 ? search.hypotheses[1].confirmations : 0;
  const bool is_near = is_where_odometry_says(best, parts[apart]);
  const int wanted = is_near ? options.confirmations : options.far_confirmations;
  const bool is_found = (is_near || search.complete) && best.confirmations >= wanted &&
                        best.confirmations >= next + wanted - 1;
  if (!is_found) {
    return std::nullopt;
  }
  if (!is_near && !fits_whole(best, parts, apart, places, doubt)) {
    search.hypotheses.erase(search.hypotheses.begin());
    return std::nullopt;
  }
  return best;
}

}  // namespace matchbox_slam
