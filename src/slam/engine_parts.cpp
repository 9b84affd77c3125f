#include "slam/engine_parts.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "slam/insertion.hpp"
#include "slam/pose_uncertainty.hpp"
#include "slam/scan_evidence.hpp"

namespace matchbox_slam {
namespace {

/// Before it is matched.
ScanOutcome outcome_of(const ScanInput& input, const MotionPrediction& predicted) {
  ScanOutcome outcome;
  outcome.stamp = input.scan.stamp;
  outcome.map_from_base = predicted.fixed_from_base;
  outcome.covariance = predicted.covariance;
  outcome.predicted_map_from_base = predicted.fixed_from_base;
  if (input.odometry && !input.odometry->is_heading_only) {
    outcome.odom_from_base = input.odometry->odom_from_base;
  }
  return outcome;
}

}  // namespace

SlamEngine::Parts::Parts(const EngineOptions& options, std::shared_ptr<const ScanMatcher> matcher,
                         std::uint64_t seed, const Pose2& start)
    : matcher_(std::move(matcher)), seed_(seed), tracker_(options.motion), mapping_(options) {
  tracker_.set_pose(start, Eigen::Matrix3d::Zero());
}

ScanOutcome SlamEngine::Parts::process(const ScanInput& input) {
  MotionPrediction predicted = tracker_.predict(input);
  if (!secondary_lasers_.select_primary(input, tracker_.state().stamp)) {
    return take_secondary(input, predicted);
  }
  const Pose2 before = tracker_.state().fixed_from_base;
  const double seconds = input.scan.stamp - tracker_.state().stamp.value_or(input.scan.stamp);
  const std::optional<MotionPrediction> steady = tracker_.predict_steadily(input);
  collect_scans(input, predicted, !steady);
  ScanOutcome outcome = outcome_of(input, predicted);
  outcome.match = match(predicted);
  const Verdict verdict = weigh(predicted, steady, seconds, outcome);
  const MatchedMotion matched = tracker_.after_match(input, predicted, outcome.match);
  outcome.map_from_base = matched.fixed_from_base;
  outcome.covariance = outcome.match.covariance;
  if (verdict != Verdict::kUnknown) {
    draw(input, matched.during_scan, outcome);
  }
  remember(input, predicted, outcome);
  const Pose2 newest_before = outcome.corrected ? outcome.corrected->newest * before : before;
  secondary_lasers_.move_on(newest_before.inverse() * outcome.map_from_base);
  ++scan_count_;
  // What may move the map waits until it is decided where the robot is.
  const bool is_decided = !hypotheses_.is_forked();
  if (is_decided && outcome.inserted) {
    close_loops(outcome);
  }
  mapping_.catch_up();
  if (is_decided) {
    outcome.left_out += mapping_.insert_pending();
  }
  if (verdict == Verdict::kUnknown) {
    mapping_.forget_since_fork();
    outcome.gave_up_component = begin_component(input.scan.stamp);
  } else if (is_component_unmatched(outcome, predicted)) {
    be_lost(input.scan.stamp);  // what was seen before is of no map
    relocalizer_.begin_anew();
  } else if (mapping_.is_lost() && outcome.match.accepted()) {
    search_for_map(outcome);
  }
  outcome.covariance += hypotheses_.spread_around(outcome.map_from_base);
  outcome.covariance =
      reported_covariance(outcome, mapping_.components(), options().slam.update_map);
  outcome.state = state();
  return outcome;
}

void SlamEngine::Parts::draw(const ScanInput& input, const Pose2& during_scan,
                             ScanOutcome& outcome) {
  if (is_to_be_inserted(input, outcome, mapping_.components(), tracker_.state().matched,
                        options().slam)) {
    bundle_.correct_motion(during_scan, projector_);
    insert(bundle_, input.laser, mapping_, outcome);
    hypotheses_.note_key_scans(active_key_scans(), outcome.map_from_base);
  } else if (!hypotheses_.is_forked() &&  // what is drawn over the map is not moved afterwards
             is_to_be_drawn_over(bundle_.all(), input.laser, outcome, mapping_)) {
    bundle_.correct_motion(during_scan, projector_);
    draw_over(bundle_, input.laser, mapping_, outcome);
  }
}

/// Whether a component has just begun, and the scan does not match it where its motion leads to, as
/// while the robot is carried.
bool SlamEngine::Parts::is_component_unmatched(const ScanOutcome& outcome,
                                               const MotionPrediction& predicted) const {
  if (!mapping_.components().has_just_begun() ||
      outcome.match.status == MatchStatus::kRejectedNoReference) {
    return false;
  }
  return !outcome.match.accepted() || PoseHypotheses::is_jump(outcome.match, predicted);
}

/// What a secondary laser sees: where it is is the prediction.
ScanOutcome SlamEngine::Parts::take_secondary(const ScanInput& input,
                                              const MotionPrediction& predicted) {
  const MotionState& newest = tracker_.state();
  const Pose2 newest_from_base = newest.fixed_from_base.inverse() * predicted.fixed_from_base;
  if (newest.matched && !hypotheses_.is_forked() && !mapping_.is_lost() &&
      secondary_lasers_.is_sample_due(input.laser, newest_from_base)) {
    const PointScan scan = project_scan(input.scan, input.base_from_laser, predicted.during_scan,
                                        options().scan, input.laser_motion);
    secondary_lasers_.sample(input.laser, scan, predicted.fixed_from_base, newest_from_base,
                             newest.velocity(), mapping_.components().map().key_scans.all(),
                             options().map, options().field);
  }
  secondary_lasers_.wait(input, newest.velocity(), newest_from_base, predicted.during_scan,
                         options().scan);
  ScanOutcome outcome = outcome_of(input, predicted);
  outcome.covariance += hypotheses_.spread_around(newest.fixed_from_base);
  outcome.covariance = reported_covariance(outcome, mapping_.components(), false);
  outcome.match.map_from_base = predicted.fixed_from_base;
  outcome.match.covariance = predicted.covariance;
  outcome.is_of_secondary_laser = true;
  outcome.state = state();
  return outcome;
}

/// Where odometry tells of an improbable step, nobody knows where between the lasers' scans it
/// lies: then the primary one's counts alone.
void SlamEngine::Parts::collect_scans(const ScanInput& input, const MotionPrediction& predicted,
                                      bool with_secondary_lasers) {
  const MotionState& newest = tracker_.state();
  std::map<int, SecondaryScan> secondary = secondary_lasers_.take_waiting(
      input.scan.stamp, newest.fixed_from_base.inverse() * predicted.fixed_from_base);
  if (!with_secondary_lasers) {
    secondary.clear();
  }
  bundle_.assign(input, secondary_lasers_.base_from_laser(input, newest.velocity()),
                 predicted.during_scan, options().scan, std::move(secondary), projector_);
}

MatchResult SlamEngine::Parts::match(const MotionPrediction& predicted) {
  mapping_.components().active().key_scans.copy_newest(
      static_cast<std::size_t>(options().slam.recent_scans), recent_);
  const SlamMap& map = mapping_.matched();
  const MatchProblem problem{
      bundle_.all(), predicted.fixed_from_base,    predicted.covariance,       map.field,
      recent_,       mix_seed(seed_, scan_count_), predicted.search_covariance};
  if (map.field.empty()) {
    return rejected(problem, MatchStatus::kRejectedNoReference);
  }
  if (problem.scan.points.size() < static_cast<std::size_t>(options().slam.min_points)) {
    return rejected(problem, MatchStatus::kRejectedTooFewPoints);
  }
  return common_ground_.match(*matcher_, problem, map);
}

/// Where the robot is, by all that speaks for it and against.
SlamEngine::Parts::Verdict SlamEngine::Parts::weigh(MotionPrediction& predicted,
                                                    const std::optional<MotionPrediction>& steady,
                                                    double seconds, ScanOutcome& outcome) {
  const MatchStatus status = outcome.match.status;
  const bool is_prediction_only = outcome.match.accepted() && outcome.match.score == 0.0;
  if (status == MatchStatus::kRejectedNoReference || status == MatchStatus::kRejectedTooFewPoints ||
      is_prediction_only || predicted.covariance.isZero(0.0)) {
    hypotheses_.leave_out(predicted.motion);
    return Verdict::kLeads;
  }
  const bool was_in_doubt = hypotheses_.is_in_doubt(options().hypotheses);
  const bool was_forked = hypotheses_.is_forked();
  PoseHypotheses::Outcome weighed =
      hypotheses_.follow({bundle_.all(), mapping_.compared(), mapping_.matched(),
                          active_key_scans(), recent_, seconds, predicted, steady},
                         outcome.match, options().hypotheses);
  outcome.evidence = weighed.evidence;
  outcome.match = weighed.match;
  if (hypotheses_.is_forked() && !was_forked) {
    mapping_.fork();
  } else if (weighed.is_jump && was_in_doubt && hypotheses_.is_forked()) {
    // From one jump to the next nobody knows where it was.
    mapping_.forget_since_fork();
    hypotheses_.forget_key_scans();
    weighed.key_scans.clear();
    search_anew_if_lost();
  }
  if (!outcome.match.accepted() && options().hypotheses.enabled) {
    // Where the next match may be believed that this one was refused for, nothing is drawn.
    const bool is_new_ground = outcome.match.status != MatchStatus::kRejectedUnexpected &&
                               weighed.evidence.known < kMinKnownShare;
    outcome.certainty = is_new_ground ? Certainty::kNewGround : Certainty::kUnmatched;
  }
  if (weighed.verdict == Verdict::kOvertaken) {
    follow(weighed, predicted, outcome);
  }
  if (!hypotheses_.is_forked()) {
    mapping_.unfork();
  }
  return weighed.verdict;
}

/// Key scans that a lost robot was looked for with are no more, or elsewhere.
void SlamEngine::Parts::search_anew_if_lost() {
  if (mapping_.is_lost()) {
    relocalizer_.begin_anew();
  }
}

/// The robot, and what it saw since the fork, is where another hypothesis has it.
void SlamEngine::Parts::follow(const PoseHypotheses::Outcome& overtaken,
                               MotionPrediction& predicted, ScanOutcome& outcome) {
  const Pose2 new_from_old = overtaken.match.map_from_base * overtaken.before.inverse();
  outcome.corrected = mapping_.move_since_fork(overtaken.key_scans, new_from_old, outcome.stamp);
  search_anew_if_lost();
  tracker_.change_frame(new_from_old);
  tracker_.forget_motion();  // from where it was wrongly thought to be there is none
  predicted.fixed_from_base = new_from_old * predicted.fixed_from_base;
  outcome.predicted_map_from_base = predicted.fixed_from_base;
  outcome.certainty = Certainty::kOvertaken;
}

void SlamEngine::Parts::remember(const ScanInput& input, const MotionPrediction& predicted,
                                 const ScanOutcome& outcome) {
  const bool is_believed =
      !hypotheses_.is_in_doubt(options().hypotheses) && outcome.certainty != Certainty::kOvertaken;
  if (is_believed && outcome.match.accepted()) {
    tracker_.learn(input, predicted, outcome.match);
  }
  Eigen::Matrix3d covariance = outcome.covariance;
  if (outcome.inserted) {  // the frame of a map lies where its first scan does
    const bool begins_map = outcome.match.status == MatchStatus::kRejectedNoReference;
    covariance = begins_map ? Eigen::Matrix3d::Zero() : beside_drawn(outcome.covariance);
  }
  tracker_.remember(input, predicted, outcome.map_from_base, covariance,
                    outcome.match.accepted() || outcome.inserted);
}

void SlamEngine::Parts::close_loops(ScanOutcome& outcome) {
  if (mapping_.is_lost() || !mapping_.closes_loops()) {
    return;
  }
  std::optional<MapCorrection> corrected = mapping_.close_loops();
  if (corrected) {
    const Pose2 new_from_old = corrected->newest;
    outcome.corrected = std::move(corrected);
    tracker_.change_frame(new_from_old);
    outcome.map_from_base = new_from_old * outcome.map_from_base;
    outcome.predicted_map_from_base = new_from_old * outcome.predicted_map_from_base;
  }
}

std::optional<MapCorrection> SlamEngine::Parts::finish_loops() {
  std::optional<MapCorrection> correction = mapping_.finish_loops();
  mapping_.catch_up();
  if (correction) {
    tracker_.change_frame(correction->newest);
  }
  return correction;
}

TrackingState SlamEngine::Parts::state() const {
  if (mapping_.is_lost()) {
    return TrackingState::kLost;
  }
  if (hypotheses_.is_in_doubt(options().hypotheses)) {
    return TrackingState::kDoubt;
  }
  return mapping_.has_pending() ? TrackingState::kRecovered : TrackingState::kTracking;
}

// --- where the robot is ---

std::vector<WeightedPose> SlamEngine::Parts::likely_poses() const {
  const Pose2& here = tracker_.state().fixed_from_base;
  std::vector<WeightedPose> poses;
  double sum = 0.0;
  if (mapping_.is_lost()) {
    for (const PlaceHypothesis& place : relocalizer_.search().hypotheses) {
      if (place.component == 0) {
        // It may be as sure as it likes, and stay a number.
        constexpr double kMaxLogOdds = 100.0;
        poses.push_back(
            {place.component_from_active * here, std::exp(std::min(place.log_odds, kMaxLogOdds))});
      }
    }
    sum = std::exp(kPriorAgainstCarried);
  } else {
    const HypothesesState& state = hypotheses_.state();
    poses.push_back({here, 1.0});
    for (const PoseHypothesis& other : state.others) {
      poses.push_back({other.map_from_base, std::exp(other.log_odds)});
    }
    sum = std::exp(state.elsewhere);
  }
  for (const WeightedPose& pose : poses) {
    sum += pose.weight;
  }
  for (WeightedPose& pose : poses) {
    pose.weight /= sum;
  }
  const auto first_other = poses.begin() + (mapping_.is_lost() || poses.empty() ? 0 : 1);
  std::stable_sort(first_other, poses.end(), [](const WeightedPose& a, const WeightedPose& b) {
    return a.weight > b.weight;
  });
  return poses;
}

void SlamEngine::Parts::believe() {
  hypotheses_.believe();
  mapping_.unfork();
}

bool SlamEngine::Parts::begin_component(double stamp) {
  // [s] a key scan; what is searched is drawn meanwhile.
  constexpr double kDrawingTimePerScan = 0.003;
  const Mapping::BegunComponent begun = be_lost(stamp);
  // Where another component had just begun, the drawing that was for that one is still under way.
  const double since =
      begun.is_drawn_beside
          ? stamp + kDrawingTimePerScan *
                        static_cast<double>(mapping_.components().map().key_scans.size())
          : relocalizer_.search().stamp;
  relocalizer_.begin(since);
  return begun.gave_up_component;
}

Mapping::BegunComponent SlamEngine::Parts::be_lost(double stamp) {
  mapping_.unfork();
  hypotheses_.begin_lost();
  // Nor is it known how it moves: the next two matches will tell.
  tracker_.set_pose(tracker_.state().fixed_from_base, tracker_.state().covariance);
  return mapping_.begin_component(stamp);
}

void SlamEngine::Parts::search_for_map(ScanOutcome& outcome) {
  if (!relocalizer_.has_begun(outcome.stamp)) {
    return;
  }
  static_cast<void>(mapping_.whole());
  const std::optional<PlaceHypothesis> found =
      relocalizer_.find(outcome.stamp, outcome.map_from_base, mapping_.components(), options());
  if (!found) {
    return;
  }
  const double begin = mapping_.components().active().begin;
  join(*found);
  outcome.joined = ScanOutcome::Joined{begin, found->component_from_active};
  outcome.map_from_base = tracker_.state().fixed_from_base;
  outcome.predicted_map_from_base = found->component_from_active * outcome.predicted_map_from_base;
  outcome.match.map_from_base = found->component_from_active * outcome.match.map_from_base;
  outcome.match.covariance =
      in_turned_frame(outcome.match.covariance, -found->component_from_active.theta);
  outcome.covariance = tracker_.state().covariance + covariance_where_found();
}

/// Puts what the component holds where it belongs, a few key scans with each of the next scans.
void SlamEngine::Parts::join(const PlaceHypothesis& found) {
  tracker_.change_frame(found.component_from_active);
  mapping_.join(found.component, found.component_from_active);
  believe();
  relocalizer_.begin();
}

void SlamEngine::Parts::set_pose(const Pose2& map_from_base, const Eigen::Matrix3d& covariance) {
  tracker_.set_pose(map_from_base, covariance);
  mapping_.go_to_map();
  believe();
  relocalizer_.begin();
}

// --- options ---

void SlamEngine::Parts::set_options(const EngineOptions& options) {
  check_map(mapping_.components().map().map, options);
  tracker_.set_options(options.motion);
  if (!options.hypotheses.enabled) {
    believe();
  }
  mapping_.set_options(options);
}

}  // namespace matchbox_slam
