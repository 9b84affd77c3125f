#include "slam/insertion.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "slam/scan_evidence.hpp"

namespace matchbox_slam {
namespace {

/// A laser at half the tilt of when it took its newest key scan: what it sees before its beams
/// leave the band of heights reaches twice as far. Below a hundredth of a radian it sees all either
/// way.
bool sees_farther(const ScanInput& input, const KeyScans& key_scans) {
  constexpr double kMinTilt = 0.01;  // [rad]
  const PlacedScans& all = key_scans.all();
  const auto newest = std::find_if(all.rbegin(), all.rend(), [&](const PlacedScan& placed) {
    return placed.scan->laser() == input.laser && placed.scan->base_from_laser() != nullptr;
  });
  if (newest == all.rend()) {
    return false;
  }
  const double tilt = tilt_of(*newest->scan->base_from_laser());
  return tilt > kMinTilt && tilt_of(input.base_from_laser) < 0.5 * tilt;
}

/// Of a match that says so little of its heading, as from within a cupboard, what is 5 m away would
/// be drawn 0.25 m off.
bool is_heading_known(const MatchResult& match) {
  constexpr double kMaxHeadingSigma = 0.05;  // [rad]; key scans of logs have less
  return match.score == 0.0 || match.covariance(2, 2) <= kMaxHeadingSigma * kMaxHeadingSigma;
}

/// Whether it is hardly known where a scan was seen, while the next one, or the one after, may be
/// matched better with what is drawn already: what is drawn off its place draws all that follow
/// after it. Where nothing tells for longer, the map goes on without.
bool is_to_wait(const ScanOutcome& outcome, const Pose2& moved, const SlamOptions& options) {
  constexpr double kMaxSigma = 0.05;    // [m], a cell
  constexpr double kLongestWait = 3.0;  // of the usual way between key scans
  const MatchResult& match = outcome.match;
  return match.accepted() && match.score > 0.0 &&
         outcome.covariance.topLeftCorner<2, 2>().trace() > kMaxSigma * kMaxSigma &&
         moved.translation().norm() < kLongestWait * options.insert_distance &&
         std::abs(moved.theta) < kLongestWait * options.insert_angle;
}

/// @param last          map_from_base of what was drawn, by laser.
/// @param sees_farther  the laser, than with that.
bool is_worth_drawing(const ScanOutcome& outcome, int laser, const std::map<int, Pose2>& last,
                      bool sees_farther, const SlamOptions& options) {
  const auto before = last.find(laser);
  if (before == last.end()) {
    return true;
  }
  const Pose2 moved = before->second.inverse() * outcome.map_from_base;
  if (is_to_wait(outcome, moved, options)) {
    return false;
  }
  return moved.translation().norm() >= options.insert_distance ||
         std::abs(moved.theta) >= options.insert_angle ||
         outcome.match.score < options.insert_overlap || sees_farther;
}

void insert_one(const PointScan& scan, const MeasuredScan& measured, int laser, Mapping& mapping,
                ScanOutcome& outcome) {
  const PlacedScan placed{std::make_shared<const KeyScan>(measured, 0, laser),
                          outcome.map_from_base};
  outcome.inserted = mapping.insert(scan, placed, outcome.covariance);
  outcome.left_out = outcome.inserted ? 0 : 1;
}

}  // namespace

bool is_to_be_inserted(const ScanInput& input, const ScanOutcome& outcome,
                       const MapComponents& components, bool was_matched,
                       const SlamOptions& options) {
  const MatchResult& match = outcome.match;
  const MapComponent& active = components.active();
  if (!options.update_map && !components.is_lost()) {
    return false;
  }
  if (outcome.certainty == Certainty::kNewGround || (match.accepted() && is_heading_known(match))) {
    return is_worth_drawing(outcome, input.laser, active.last_inserted,
                            sees_farther(input, active.key_scans), options);
  }
  return active.map.field.empty() ||
         (match.status == MatchStatus::kRejectedLowScore && was_matched &&
          !active.last_inserted.empty() && active.last_inserted.count(input.laser) == 0);
}

void insert(const ScanBundle& bundle, int laser, Mapping& mapping, ScanOutcome& outcome) {
  insert_one(bundle.points(), bundle.primary(), laser, mapping, outcome);
  for (const auto& [secondary, one] : bundle.secondary()) {
    ScanOutcome beside = outcome;
    beside.map_from_base = outcome.map_from_base * one.there_from_base;
    insert_one(project_scan(one.measured), one.measured, secondary, mapping, beside);
    outcome.left_out += beside.left_out;
  }
}

bool is_to_be_drawn_over(const PointScan& scan, int laser, const ScanOutcome& outcome,
                         const Mapping& mapping) {
  const SlamOptions& options = mapping.options().slam;
  return !options.update_map && !mapping.is_lost() && outcome.match.accepted() &&
         is_heading_known(outcome.match) &&
         is_worth_drawing(outcome, laser, mapping.temporary().last_drawn(), false, options) &&
         evidence_of(scan, outcome.map_from_base, mapping.lasting()).known >= kMinKnownShare;
}

void draw_over(const ScanBundle& bundle, int laser, Mapping& mapping, const ScanOutcome& outcome) {
  mapping.draw_over(bundle.points(), laser, outcome.map_from_base);
  for (const auto& [secondary, one] : bundle.secondary()) {
    mapping.draw_over(project_scan(one.measured), secondary,
                      outcome.map_from_base * one.there_from_base);
  }
}

}  // namespace matchbox_slam
