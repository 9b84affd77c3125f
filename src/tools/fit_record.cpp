#include "tools/fit_record.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "evaluation/error_statistics.hpp"

namespace matchbox_slam {
namespace {

// Good runs, on all recordings that were tried and with every matcher: 98 % and more of the scans
// match, less than 1 % are in doubt and for up to 24 s, scores are 0.7 and more in the median, and
// the evidence of a beam 2 and more where what it sees is mapped.
constexpr double kMinMatchedShare = 0.9;
constexpr double kMaxUnsureShare = 0.05;
constexpr double kMaxUnsureTime = 30.0;  // s
constexpr double kMostlyLostShare = 0.9;
constexpr float kPoorScore = 0.5F;
constexpr float kPoorEvidence = 1.0F;
// Both lasers of a robot whose tf is a little off: 60 % of the steps; one alone, and all others: 0.
constexpr double kMaxJumpShare = 0.1;
constexpr double kJump = 0.05;        // m
constexpr double kMaxStepTime = 0.3;  // s, in which no odometry errs by that
constexpr double kMaxStep = 0.3;      // m likewise: where stamps are made up more may lie between

bool is_sure(TrackingState state) {
  return state == TrackingState::kTracking || state == TrackingState::kRecovered;
}

}  // namespace

void FitRecord::add(const ScanOutcome& outcome) {
  if (outcome.is_of_secondary_laser) {
    has_secondary_lasers_ = true;
    return;
  }
  ++scans_;
  lost_ += outcome.state == TrackingState::kLost ? 1 : 0;
  ++statuses_[outcome.match.status];
  if (outcome.match.accepted()) {
    scores_.push_back(static_cast<float>(outcome.match.score));
    evidences_.push_back(static_cast<float>(outcome.evidence.mean));
  }
  first_stamp_ = first_stamp_ ? first_stamp_ : outcome.stamp;
  if (unsure_since_) {
    unsure_ += outcome.stamp - last_stamp_;
    if (outcome.stamp - *unsure_since_ > longest_) {
      longest_ = outcome.stamp - *unsure_since_;
      longest_since_ = *unsure_since_;
    }
  }
  if (outcome.odom_from_base) {
    const Pose2 map_from_odom = outcome.map_from_base * outcome.odom_from_base->inverse();
    const double way = (last_odometry_.inverse() * *outcome.odom_from_base).translation().norm();
    last_odometry_ = *outcome.odom_from_base;
    if (map_from_odom_ && outcome.stamp - last_stamp_ < kMaxStepTime && way < kMaxStep) {
      const Pose2 expected = *map_from_odom_ * *outcome.odom_from_base;
      const double off = (expected.translation() - outcome.map_from_base.translation()).norm();
      ++steps_;
      jumps_ += off > kJump ? 1 : 0;
    }
    map_from_odom_ = map_from_odom;
  }
  last_stamp_ = outcome.stamp;
  unsure_since_ = is_sure(outcome.state)
                      ? std::nullopt
                      : std::optional<double>(unsure_since_.value_or(outcome.stamp));
}

bool FitRecord::is_mostly_lost() const {
  return scans_ > 0 && static_cast<double>(lost_) >= kMostlyLostShare * static_cast<double>(scans_);
}

std::size_t FitRecord::count_of(MatchStatus status) const {
  const auto found = statuses_.find(status);
  return found == statuses_.end() ? 0 : found->second;
}

std::vector<std::string> FitRecord::warnings(const std::string& place_told_by) const {
  std::vector<std::string> texts;
  for (std::string& text :
       std::vector{text_of_few_matches(), text_of_doubt(), text_of_poor_fit(place_told_by),
                   text_of_jumps(place_told_by)}) {
    if (!text.empty()) {
      texts.push_back(text);
    }
  }
  return texts;
}

std::string FitRecord::text_of_few_matches() const {
  const std::size_t without_map = count_of(MatchStatus::kRejectedNoReference);
  const std::size_t starting = std::min<std::size_t>(1, without_map);  // the first starts the map
  const std::size_t tried = scans_ - starting;
  if (static_cast<double>(matched()) >= kMinMatchedShare * static_cast<double>(tried)) {
    return "";
  }
  std::string text = fmt::format(
      "only {} of {} scans match the map; the others are placed by the prediction alone", matched(),
      tried);
  const auto add = [&](std::size_t count, const std::string& reason) {
    if (count > 0) {
      text += fmt::format("; {} {}", count, reason);
    }
  };
  add(count_of(MatchStatus::kRejectedTooFewPoints),
      "have too few hits: see slam/min_points and what scan/* leaves out");
  add(count_of(MatchStatus::kRejectedLowScore),
      "fit nowhere near the prediction: see motion/* and the matcher's window");
  add(count_of(MatchStatus::kRejectedUnexpected),
      "fit where their motion hardly leads to: see motion/*");
  add(without_map - starting, "met no map: see slam/update_map and what scan/* leaves out");
  return text;
}

std::string FitRecord::text_of_doubt() const {
  const double seconds = last_stamp_ - first_stamp_.value_or(0.0);
  if (unsure_ <= kMaxUnsureShare * seconds && longest_ <= kMaxUnsureTime) {
    return "";
  }
  return fmt::format(
      "for {:.1f} of {:.1f} s it was not sure where the robot is, the longest {:.1f} s from the "
      "scan of {:.3f} s on; scans.csv has the state of each scan",
      unsure_, seconds, longest_, longest_since_);
}

std::string FitRecord::text_of_poor_fit(const std::string& place_told_by) const {
  const double score = statistics_of(scores_).median;
  const double evidence = statistics_of(evidences_).median;
  const bool is_matched = score > 0.0;  // by odometry_only nothing is
  if (!is_matched || (score >= kPoorScore && evidence >= kPoorEvidence)) {
    return "";
  }
  return fmt::format(
      "the scans fit the map poorly (in the median a score of {:.2f}, and evidence of {:.1f} a "
      "beam, where 3 is the most): do the ranges, the lasers' places {} and the clocks agree? "
      "--matcher odometry_only shows what odometry alone makes of it",
      score, evidence, place_told_by);
}

std::string FitRecord::text_of_jumps(const std::string& place_told_by) const {
  const bool is_typical = 2 * steps_ >= scans_;  // else most scans are too far apart to tell
  if (!is_typical || static_cast<double>(jumps_) <= kMaxJumpShare * static_cast<double>(steps_)) {
    return "";
  }
  return fmt::format(
      "in {} of {} steps from scan to scan the pose jumps by more than 5 cm against the odometry: "
      "{} --matcher odometry_only shows what odometry alone makes of it",
      jumps_, steps_,
      fmt::format(has_secondary_lasers_
                      ? "do the lasers disagree, or their places {} and the odometry?"
                      : "is the laser's place {} right, are the stamps, or is the "
                        "odometry so bad?",
                  place_told_by));
}

}  // namespace matchbox_slam
