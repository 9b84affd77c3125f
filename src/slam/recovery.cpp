#include "slam/recovery.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/matching/contradiction.hpp"
#include "matching/hough/hough_search.hpp"
#include "matching/hough/relocalise.hpp"
#include "slam/match_validation.hpp"

namespace matchbox_slam {
namespace {

// Guesses, tried on six drives with faults (benchmark/reports/current/CONSTANTS.md): half of the
// first two finds one carried robot 0.6 s later, half or double of the others changes no byte
// there, but that of the most hypotheses, which was 24 then. How well a place is known before a
// scan is matched there: [m], [rad].
constexpr double kPlaceXy = 0.15;
constexpr double kPlaceTheta = 0.08;

constexpr std::size_t kMostHypotheses = 100;
constexpr std::size_t kChecksAtATime = 4;
constexpr std::size_t kNearEach = 5;  // key scans searched
// Poses that are looked at with one scan, beside the last key scan's. In rooms and in four logs a
// key scan takes 2 ms, and 2.5 more for 10,000 poses: so the search takes 24 ms at most there. With
// 34,500 seattle's robot is found after 25 scans in place of 23, with 42,000 a scan of aces
// takes 28. Who sets more than the five key scans of the default gets as much more.
constexpr std::size_t kMostRanked = 38000;
constexpr std::size_t kOfKeyScans = 5;

/// A scan of a lost robot, and what it is searched in.
struct LostScan {
  const PointScan& points;
  const Pose2& apart_from_base;
  const std::vector<MapPart>& parts;
  const MapPart& apart;  ///< the part that the robot makes meanwhile
  const RecoveryOptions& options;
};

bool is_farther(const Pose2& a, const Pose2& b, double distance) {
  const Pose2 moved = a.inverse() * b;
  return moved.translation().norm() >= distance || std::abs(moved.theta) >= distance;
}

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

CheckedMatch match_at(const PointScan& scan, const Pose2& part_from_base, double xy, double theta,
                      const MapPart& part) {
  const PlacedScans none;
  return search_and_check({scan, part_from_base, covariance_of(xy, theta), part.map.field, none, 0},
                          part.map.occupancy);
}

/// A place is refuted where the scan clearly contradicts it; one where little is mapped says
/// nothing.
enum class Verdict { kConfirmed, kOpen, kRefuted };

/// By half as much again as what is suspicious: here a place is dropped for good.
bool is_refuted(double violation) { return violation > 1.5 * kMostViolation; }

Verdict judge(const CheckedMatch& checked, bool is_near, const RecoveryOptions& options) {
  const MatchResult& match = checked.match;
  // What a corridor does not hold fits all along it: there odometry has to tell.
  const bool is_held = is_near || match.unconstrained_directions.empty();
  if (is_convincing(checked) && is_held && (is_near || match.score >= options.least_score)) {
    return Verdict::kConfirmed;
  }
  return is_refuted(checked.violation) ? Verdict::kRefuted : Verdict::kOpen;
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

void drop_copies(PlaceSearch& search) {
  std::vector<PlaceHypothesis>& hypotheses = search.hypotheses;
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const auto& a, const auto& b) { return a.confirmations > b.confirmations; });
  std::vector<PlaceHypothesis> kept;
  for (const PlaceHypothesis& hypothesis : hypotheses) {
    const bool is_new = std::none_of(kept.begin(), kept.end(), [&](const PlaceHypothesis& other) {
      return is_near(other, hypothesis);
    });
    if (is_new) {
      kept.push_back(hypothesis);
    }
  }
  if (kept.size() > kMostHypotheses) {
    kept.resize(kMostHypotheses);
    search.complete = false;  // what is dropped unheard may be right
  }
  hypotheses = std::move(kept);
}

/// Looks again at the hypotheses that were not looked at for some way, a few at a time.
void check_hypotheses(const LostScan& lost, std::vector<PlaceHypothesis>& hypotheses) {
  std::vector<PlaceHypothesis> kept;
  std::size_t checks = 0;
  for (PlaceHypothesis& hypothesis : hypotheses) {
    if (is_farther(hypothesis.apart_from_base, lost.apart_from_base, lost.options.distance) &&
        checks < kChecksAtATime) {
      ++checks;
      const CheckedMatch found =
          match_at(lost.points, hypothesis.part_from_apart * lost.apart_from_base, kPlaceXy,
                   kPlaceTheta, lost.parts[hypothesis.part]);
      const Verdict verdict =
          judge(found, is_where_odometry_says(hypothesis, lost.apart), lost.options);
      if (verdict == Verdict::kRefuted) {
        continue;
      }
      hypothesis.apart_from_base = lost.apart_from_base;
      if (verdict == Verdict::kConfirmed) {
        ++hypothesis.confirmations;
        hypothesis.part_from_apart = found.match.map_from_base * lost.apart_from_base.inverse();
      }
    }
    kept.push_back(hypothesis);
  }
  hypotheses = std::move(kept);
}

/// Key scans on the way to where the robot is, newest first, so far apart that each says something
/// new; those of one laser, as another one may see little.
PlacedScans way_of(const LostScan& lost) {
  PlacedScans way;
  Pose2 before = lost.apart_from_base;
  const PlacedScans& all = lost.apart.key_scans.all();
  for (auto key = all.rbegin();
       key != all.rend() && way.size() < static_cast<std::size_t>(lost.options.far_confirmations);
       ++key) {
    if (key->scan->laser() == all.front().scan->laser() &&
        is_farther(before, key->map_from_base, lost.options.distance)) {
      before = key->map_from_base;
      way.push_back(*key);
    }
  }
  return way;
}

/// How many key scans of the way speak for a place, and against it.
struct Votes {
  int confirm = 0;
  int refute = 0;
};

/// @param least  of confirmations less refutations: where that can no longer be reached, the votes
///               are those until then.
Votes votes_of(const PlacedScans& way, const LostScan& lost, const PlaceHypothesis& place,
               int least) {
  const MapPart& part = lost.parts[place.part];
  Votes votes;
  PlacedScans open;
  for (const PlacedScan& key : way) {  // the cheap question first
    const Pose2 part_from_base = place.part_from_apart * key.map_from_base;
    if (is_refuted(contradiction(*key.scan->points(), part_from_base, part.map.field))) {
      ++votes.refute;
    } else {
      open.push_back({key.scan, part_from_base});
    }
  }
  auto left = static_cast<int>(open.size());
  for (const PlacedScan& key : open) {
    if (votes.confirm + left - votes.refute < least) {
      break;
    }
    --left;
    const Verdict verdict =
        judge(match_at(*key.scan->points(), key.map_from_base, kPlaceXy, kPlaceTheta, part), false,
              lost.options);
    votes.confirm += verdict == Verdict::kConfirmed ? 1 : 0;
    votes.refute += verdict == Verdict::kRefuted ? 1 : 0;
  }
  return votes;
}

Votes votes_of(const PlacedScans& way, const LostScan& lost, const PlaceHypothesis& place) {
  return votes_of(way, lost, place, -static_cast<int>(way.size()));
}

/// What was seen on the way speaks for a far place or against it, as what comes will, so that a
/// robot that stands is found, too. Whether it does not speak against it.
bool agrees_with_way(const PlacedScans& way, const LostScan& lost, PlaceHypothesis& place) {
  const Votes votes = votes_of(way, lost, place, 1 - place.confirmations);
  place.confirmations += votes.confirm - votes.refute;
  return place.confirmations > 0;
}

/// Adds the places around a key scan where the scan fits. Returns how many poses were looked at, or
/// what takes as long.
std::size_t find_around(const LostScan& lost, const SearchedScan& searched,
                        const SearchedPlace& place, std::vector<PlaceHypothesis>& hypotheses) {
  const MapPart& part = lost.parts[place.part];
  constexpr std::size_t kTries = 3;  // a guess; half or double changes no byte (CONSTANTS.md)
  // A match takes some 0.4 ms.
  constexpr std::size_t kPosesAMatch = 1500;
  const KeyScanSearch search = search_anywhere(searched, place.key, HoughOptions{}, kTries);
  std::size_t looked_at = search.ranked;
  for (const RankedPose& pose : search.poses) {
    // Cheap, and most are none: the walls of the part, which are more than the key scan's.
    if (is_refuted(contradiction(lost.points, pose.map_from_base, part.map.field))) {
      continue;
    }
    looked_at += kPosesAMatch;
    const CheckedMatch checked =
        match_at(lost.points, pose.map_from_base, kPlaceXy, kPlaceTheta, part);
    PlaceHypothesis found{place.part, checked.match.map_from_base * lost.apart_from_base.inverse(),
                          1, lost.apart_from_base};
    const bool is_where_said = is_where_odometry_says(found, lost.apart);
    const bool is_new =
        std::none_of(hypotheses.begin(), hypotheses.end(),
                     [&found](const PlaceHypothesis& other) { return is_near(other, found); });
    if (!is_new || judge(checked, is_where_said, lost.options) != Verdict::kConfirmed) {
      continue;
    }
    const PlacedScans way = is_where_said ? PlacedScans{} : way_of(lost);
    looked_at += kPosesAMatch * way.size();
    if (is_where_said || agrees_with_way(way, lost, found)) {
      hypotheses.push_back(found);
    }
  }
  return looked_at;
}

/// Looks where odometry says that the robot is in the part that it left.
void look_near(const LostScan& lost, std::vector<PlaceHypothesis>& hypotheses) {
  constexpr double kXy = 0.5;     // [m]
  constexpr double kTheta = 0.3;  // [rad], a guess; half or double changes no byte (CONSTANTS.md)
  const std::size_t left = lost.apart.left;
  if (&lost.parts[left] == &lost.apart) {
    return;
  }
  const CheckedMatch found = match_at(lost.points, lost.apart.left_from_here * lost.apart_from_base,
                                      kXy, kTheta, lost.parts[left]);
  if (judge(found, true, lost.options) == Verdict::kConfirmed) {
    hypotheses.push_back({left, found.match.map_from_base * lost.apart_from_base.inverse(), 1,
                          lost.apart_from_base});
  }
}

void add_hypotheses(const LostScan& lost, const std::vector<SearchedPlace>& places,
                    std::size_t most, PlaceSearch& search) {
  const SearchedScan searched(lost.points, HoughOptions{}.alignment.point_spacing);
  const std::size_t count = std::min(most, places.size());
  const std::size_t most_ranked = kMostRanked * std::max<std::size_t>(1, most / kOfKeyScans);
  std::size_t ranked = 0;
  for (std::size_t i = 0; i < count && ranked < most_ranked; ++i) {
    search.next = std::min(search.next, places.size() - 1);
    ranked += find_around(lost, searched, places[search.next++], search.hypotheses);
    if (search.next == places.size()) {
      search.next = 0;
      search.complete = true;
    }
  }
}

/// Share of key scans of one part, of those that lie within another, that would see through walls
/// of that: of so many of them, spread evenly, that no scan waits long.
double share_through_walls(const PlacedScans& keys, const MapPart& other,
                           const Pose2& other_from_part) {
  constexpr std::size_t kMaxLookedAt = 30;  // a guess: half and double were not tried
  const CellBox known = other.map.occupancy.known_bounds();
  PlacedScans within;
  for (const PlacedScan& key : keys) {
    const Pose2 other_from_base = other_from_part * key.map_from_base;
    if (known.contains(other.map.occupancy.geometry().cell_at(other_from_base.translation()))) {
      within.push_back({key.scan, other_from_base});
    }
  }
  const std::size_t stride = within.size() / kMaxLookedAt + 1;
  std::size_t looked_at = 0;
  std::size_t through = 0;
  for (std::size_t i = 0; i < within.size(); i += stride) {
    const double against =
        contradiction(*within[i].scan->points(), within[i].map_from_base, other.map.field);
    through += against > kMostViolation ? 1 : 0;
    ++looked_at;
  }
  return looked_at > 0 ? static_cast<double>(through) / static_cast<double>(looked_at) : 0.0;
}

/// Where rooms are alike, what lies around them tells: how many key scans of either part see
/// through walls of the other, joined as the place has it.
/// @param seen  key scans of the part that the robot makes, spread out.
Verdict judge_whole(const LostScan& lost, const PlaceHypothesis& place, const PlacedScans& seen,
                    const std::vector<SearchedPlace>& places) {
  constexpr double kMinShareRefuted = 0.3;
  PlacedScans there;
  for (const SearchedPlace& searched : places) {
    if (searched.part == place.part) {
      there.push_back(searched.key);
    }
  }
  const double through =
      std::max(share_through_walls(seen, lost.parts[place.part], place.part_from_apart),
               share_through_walls(there, lost.apart, place.part_from_apart.inverse()));
  if (through > kMinShareRefuted) {
    return Verdict::kRefuted;
  }
  return through <= kMostThroughWalls ? Verdict::kConfirmed : Verdict::kOpen;
}

/// Whether no other place may be the right one as well as the first. How often each was confirmed
/// does not tell, as one may have been found long after the other: the same key scans are asked of
/// both. What is no rival is dropped, and found again if it is the right one after all. A few are
/// asked at a time, so that no scan waits long: where more are left it is not known yet.
bool is_alone(const LostScan& lost, const PlacedScans& seen,
              const std::vector<SearchedPlace>& places, std::vector<PlaceHypothesis>& hypotheses) {
  constexpr std::size_t kAskedAtATime = 2;
  if (hypotheses.size() == 1) {
    return true;
  }
  const PlacedScans way = way_of(lost);
  const Votes best = votes_of(way, lost, hypotheses.front());
  for (std::size_t asked = 0; hypotheses.size() > 1; ++asked) {
    if (asked == kAskedAtATime) {
      return false;
    }
    const auto other = hypotheses.begin() + 1;
    const Votes votes = votes_of(way, lost, *other);
    const bool is_rival = 2 * votes.confirm >= best.confirm && votes.refute <= best.refute;
    if (is_rival && judge_whole(lost, *other, seen, places) != Verdict::kRefuted) {
      return false;
    }
    hypotheses.erase(other);
  }
  return true;
}

/// Whether the first place is to be judged: confirmed often enough, and what may be as well was
/// searched.
bool is_to_be_judged(const LostScan& lost, const PlaceSearch& search) {
  if (search.hypotheses.empty()) {
    return false;
  }
  const PlaceHypothesis& best = search.hypotheses.front();
  // Asked again where something new was seen or searched.
  const bool is_news = search.next == 0 || best.apart_from_base == lost.apart_from_base;
  const bool is_where_said = is_where_odometry_says(best, lost.apart);
  const int next = search.hypotheses.size() > 1 ? search.hypotheses[1].confirmations : 0;
  const int wanted = is_where_said ? lost.options.confirmations + std::max(0, next - 1)
                                   : lost.options.far_confirmations;
  return is_news && (is_where_said || search.complete) && best.confirmations >= wanted;
}

/// The first place, if it is the right one.
std::optional<PlaceHypothesis> judge_first(const LostScan& lost,
                                           const std::vector<SearchedPlace>& places,
                                           std::vector<PlaceHypothesis>& hypotheses) {
  const PlaceHypothesis first = hypotheses.front();
  const PlacedScans seen = spread_out(lost.apart.key_scans.all());
  const Verdict whole = judge_whole(lost, first, seen, places);
  if (whole == Verdict::kRefuted) {
    hypotheses.erase(hypotheses.begin());
  }
  if (whole != Verdict::kConfirmed) {
    return std::nullopt;
  }
  const bool is_found =
      is_where_odometry_says(first, lost.apart) || is_alone(lost, seen, places, hypotheses);
  return is_found ? std::optional(first) : std::nullopt;
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
                                             const RecoveryOptions& options, PlaceSearch& search) {
  constexpr double kJitter = 0.1;  // share of an interval that is as long as that between scans
  if (scan.stamp - search.stamp < (1.0 - kJitter) * options.interval) {
    return std::nullopt;
  }
  search.stamp = scan.stamp;
  const LostScan lost{scan, apart_from_base, parts, parts[apart], options};
  check_hypotheses(lost, search.hypotheses);
  drop_copies(search);
  if (search.next != 0 && is_to_be_judged(lost, search)) {
    if (const auto found = judge_first(lost, places, search.hypotheses)) {
      return found;
    }
    // So that the scan does not wait long; not at all would be for ever where scans are rare.
    add_hypotheses(lost, places, 1, search);
    drop_copies(search);
    return std::nullopt;
  }
  const auto most = static_cast<std::size_t>(options.key_scans);
  if (search.next % kNearEach < most) {
    look_near(lost, search.hypotheses);
  }
  add_hypotheses(lost, places, most, search);
  drop_copies(search);
  return is_to_be_judged(lost, search) ? judge_first(lost, places, search.hypotheses)
                                       : std::nullopt;
}

}  // namespace matchbox_slam
