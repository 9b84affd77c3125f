#include "matchbox_slam/slam/tracking_state.hpp"

#include <algorithm>
#include <cmath>

namespace matchbox_slam {
namespace {

// Guesses, tried on six drives with faults and two logs
// (benchmark/reports/current/CONSTANTS.md): half or double of the motion changes no error by
// 1 %. With 10 contradictions a carried robot is found 4 s later, with an ATE of 0.13 m instead of
// 0.04; with 2 only one changes that is found nowhere either way.
constexpr double kDistance = 0.1;  // [m] of motion after which a scan says something new
constexpr double kAngle = 0.1;     // [rad]
constexpr int kLeastContradictions = 5;

bool is_contradicted(const WeighedMatch& match, const DoubtOptions& doubt) {
  return match.match.accepted() && match.match.contradiction > doubt.contradiction;
}

bool is_uncontradicted(const WeighedMatch& match, const DoubtOptions& doubt) {
  return match.match.accepted() && !is_contradicted(match, doubt);
}

/// A fit that speaks for itself, about as good as is usual: half as good a one of a robot that is
/// being carried may be chance. A corridor has rivals everywhere along it.
bool is_good(const WeighedMatch& match, double usual_score, const DoubtOptions& doubt) {
  return is_uncontradicted(match, doubt) &&
         match.fit >= std::max(doubt.least_score, doubt.score_drop * usual_score);
}

bool has_moved(const Pose2& map_from_before, const Pose2& map_from_now) {
  const Pose2 motion = map_from_before.inverse() * map_from_now;
  return motion.translation().norm() >= kDistance || std::abs(motion.theta) >= kAngle;
}

/// Whether nothing matched for long.
bool is_unmatched(const TrackingDoubt& doubt, const TrackingOptions& options) {
  // A guess; half or double changes no byte (CONSTANTS.md, as kLeastBlind).
  constexpr int kLeastDoubtful = 10;
  return doubt.doubts && !doubt.is_provisional && doubt.doubtful >= kLeastDoubtful &&
         doubt.way >= options.lost_way;
}

}  // namespace

const char* to_string(TrackingState state) {
  switch (state) {
    case TrackingState::kTracking:
      return "tracking";
    case TrackingState::kDoubt:
      return "doubt";
    case TrackingState::kProvisional:
      return "provisional";
    case TrackingState::kLost:
      return "lost";
    case TrackingState::kRecovered:
      return "recovered";
  }
  return "unknown";
}

void TrackingDoubt::pass(double seconds) {
  // [s], between scans of any laser that does not nod. Half or double changes no byte
  // (CONSTANTS.md), whose lasers do not nod.
  constexpr double kMost = 0.5;
  since += std::max(0.0, seconds - kMost);
}

void TrackingDoubt::follow(const WeighedMatch& match, double stamp, double way_since,
                           const Pose2& map_from_base_now, double usual_score,
                           const DoubtOptions& doubt, const TrackingOptions& options) {
  way += way_since;
  // In doubt new ground is no way out: where it is nobody knows.
  const bool is_new_doubt = doubts && !is_provisional && match.certainty == Certainty::kNewGround;
  if (match.certainty == Certainty::kDoubtful || is_new_doubt) {
    if (!doubts) {
      *this = {};
      doubts = true;
      since = stamp;
    }
    is_provisional = false;
    ++doubtful;
    contradictions += match.match.contradiction > doubt.contradiction ? 1 : 0;
    contradiction_sum += match.match.contradiction;
  } else if (match.jumped || (doubts && !is_provisional && is_uncontradicted(match, doubt))) {
    since = doubts ? since : stamp;
    doubts = true;
    is_provisional = true;
    way = 0.0;
    confirmations = 0;
    map_from_base = map_from_base_now;
  } else if (is_provisional && is_good(match, usual_score, doubt) &&
             has_moved(map_from_base, map_from_base_now)) {
    map_from_base = map_from_base_now;
    ++confirmations;
  } else if (is_provisional && is_contradicted(match, doubt) &&
             has_moved(map_from_base, map_from_base_now)) {
    map_from_base = map_from_base_now;
    --confirmations;
    way = 0.0;
  }
  if (is_provisional && (confirmations >= options.confirmations || way >= options.lost_way)) {
    *this = {};
  }
}

bool TrackingDoubt::is_blind(const TrackingOptions& options) const {
  // Share of the beams, in the mean of the doubt's scans. A guess: of 95 % of the scans of a robot
  // that is where it should be nothing contradicts; of one that was kidnapped, with a laser of 8 m,
  // 5 % did (benchmark/reports/current/FAULTS.md).
  constexpr double kHardly = 0.02;
  return is_unmatched(*this, options) && contradictions < kLeastContradictions &&
         contradiction_sum <= kHardly * doubtful;
}

bool TrackingDoubt::is_lost(double stamp, const TrackingOptions& options) const {
  const int against = is_provisional ? -confirmations : contradictions;
  const bool is_refuted =
      doubts && against >= kLeastContradictions && stamp - since >= options.lost_after;
  return is_refuted || is_unmatched(*this, options);
}

}  // namespace matchbox_slam
