#include "matchbox_slam/slam/slam_engine.hpp"

#include <iterator>
#include <utility>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "slam/insertion.hpp"
#include "slam/likeliest_match.hpp"
#include "slam/pose_uncertainty.hpp"
#include "slam/seen_scans.hpp"

namespace matchbox_slam {
namespace {

/// Before it is matched.
ScanOutcome outcome_of(const ScanInput& input, const MotionPrediction& predicted) {
  ScanOutcome outcome;
  outcome.stamp = input.scan.stamp;
  outcome.map_from_base = predicted.fixed_from_base;
  outcome.covariance = predicted.covariance;
  outcome.predicted_map_from_base = predicted.fixed_from_base;
  if (input.odometry) {
    outcome.odom_from_base = input.odometry->odom_from_base;
  }
  return outcome;
}

}  // namespace

SlamEngine::SlamEngine(const EngineOptions& options, std::shared_ptr<const ScanMatcher> matcher,
                       std::uint64_t seed, const Pose2& start)
    : options_(options),
      matcher_(std::move(matcher)),
      seed_(seed),
      tracker_(options.motion),
      mapping_(options),
      seen_(std::make_unique<SeenScans>()) {
  tracker_.set_pose(start, Eigen::Matrix3d::Zero());
}

SlamEngine::SlamEngine(SlamEngine&& other) noexcept = default;
SlamEngine& SlamEngine::operator=(SlamEngine&& other) noexcept = default;
SlamEngine::~SlamEngine() = default;

ScanOutcome SlamEngine::process(const ScanInput& input) {
  MotionPrediction predicted = tracker_.predict(input);
  if (!further_lasers_.leads(input, tracker_.state().stamp)) {
    return take_aside(input, predicted);
  }
  const Pose2 before = tracker_.state().fixed_from_base;
  const double seconds = input.scan.stamp - tracker_.state().stamp.value_or(input.scan.stamp);
  const std::optional<SteadyPrediction> steady = tracker_.predict_steadily(input);
  see(input, predicted, !(steady && steady->is_odometry_improbable));
  const WeighedMatch weighed = match(steady, predicted);
  // A rejected match carries the prediction, which stands then.
  ScanOutcome outcome = outcome_of(input, predicted);
  outcome.match = weighed.match;
  outcome.certainty = weighed.certainty;
  const MatchedMotion matched = tracker_.after_match(input, predicted, outcome.match);
  outcome.map_from_base = matched.fixed_from_base;
  outcome.covariance = outcome.match.covariance;
  weigh_doubt(weighed, predicted, outcome);
  if (mapping_.parts().is_of_one_scan() && outcome.certainty == Certainty::kNewGround) {
    outcome.gave_up_part = map_apart(input.scan.stamp);  // it may have been carried on meanwhile
  }

  if (is_to_be_inserted(input, outcome, mapping_.parts(), tracker_.state().matched,
                        options_.slam)) {
    seen_->put_right(matched.during_scan, projector_);
    insert_or_hold(*seen_, input.laser, options_, tracking_, mapping_, outcome);
  }
  remember(input, predicted, weighed.jumped, outcome);
  further_lasers_.move_on(before.inverse() * outcome.map_from_base);
  ++scan_count_;
  if (outcome.inserted) {
    close_loops(outcome);
  }
  mapping_.catch_up(options_);
  if (!tracking_.doubt().doubts) {
    outcome.left_out += mapping_.insert_pending(options_);
  }
  if (tracking_.doubt().is_lost(input.scan.stamp, options_.tracking)) {
    outcome.gave_up_part = map_apart(input.scan.stamp);
  } else if (mapping_.is_lost() && outcome.match.accepted()) {
    const double way = (before.inverse() * outcome.map_from_base).translation().norm();
    search_for_map({seconds, way}, outcome);
  }
  outcome.covariance = told_covariance(outcome, mapping_.parts(), options_.slam.update_map);
  outcome.state = state();
  return outcome;
}

/// What a laser that does not lead sees: where it is is the prediction.
ScanOutcome SlamEngine::take_aside(const ScanInput& input, const MotionPrediction& predicted) {
  const MotionState& newest = tracker_.state();
  const Pose2 newest_from_base = newest.fixed_from_base.inverse() * predicted.fixed_from_base;
  if (newest.matched && !tracking_.doubt().doubts && !mapping_.is_lost() &&
      further_lasers_.is_sample_due(input.laser, newest_from_base)) {
    const PointScan scan = project_scan(input.scan, input.base_from_laser, predicted.during_scan,
                                        options_.scan, input.laser_motion);
    further_lasers_.sample(input.laser, scan, predicted.fixed_from_base, newest_from_base,
                           newest.velocity(), key_scans().all(), options_.map, options_.field);
  }
  further_lasers_.wait(input, newest.velocity(), newest_from_base, predicted.during_scan,
                       options_.scan);
  ScanOutcome outcome = outcome_of(input, predicted);
  outcome.covariance = told_covariance(outcome, mapping_.parts(), false);
  outcome.match.map_from_base = predicted.fixed_from_base;
  outcome.match.covariance = predicted.covariance;
  outcome.match.status = MatchStatus::kOfFurtherLaser;
  outcome.state = state();
  return outcome;
}

/// Where odometry tells of a step that cannot be, nobody knows where between the lasers' scans it
/// lies: then the leading one's counts alone.
void SlamEngine::see(const ScanInput& input, const MotionPrediction& predicted,
                     bool with_further_lasers) {
  const MotionState& newest = tracker_.state();
  std::map<int, FurtherScan> further = further_lasers_.take_waiting(
      input.scan.stamp, newest.fixed_from_base.inverse() * predicted.fixed_from_base);
  if (!with_further_lasers) {
    further.clear();
  }
  seen_->assign(input, further_lasers_.base_from_laser(input, newest.velocity()),
                predicted.during_scan, options_.scan, std::move(further), projector_);
}

/// What further lasers saw lies where odometry has it: without odometry they would be left out.
WeighedMatch SlamEngine::match(std::optional<SteadyPrediction> steady,
                               MotionPrediction& predicted) {
  if (!seen_->further().empty()) {
    steady.reset();
  }
  mapping_.parts().here().key_scans.copy_newest(
      static_cast<std::size_t>(options_.slam.recent_scans), recent_);
  return match_likeliest(*matcher_,
                         {seen_->all(), mapping_.matched(), recent_, mix_seed(seed_, scan_count_),
                          tracking_.expected(), maps_on() && mapping_.is_continued()},
                         steady, predicted, options_);
}

void SlamEngine::weigh_doubt(const WeighedMatch& match, const MotionPrediction& predicted,
                             ScanOutcome& outcome) {
  if (match.jumped) {
    mapping_.break_off();
  }
  const Tracking::Held held = tracking_.follow(
      match, outcome.stamp, outcome.stamp - tracker_.state().stamp.value_or(outcome.stamp),
      predicted.motion.previous_from_current.translation().norm(), outcome.map_from_base, options_);
  mapping_.wait(held.confirmed);
  if (held.is_any_dropped) {
    mapping_.expect_no_more();
  }
  if (maps_on() && tracking_.doubt().is_blind(options_.tracking)) {
    // Nothing says that it is elsewhere. How badly it is known where, the graph is told.
    tracking_.believe();
    outcome.certainty = Certainty::kNewGround;
    outcome.covariance = predicted.covariance;
  }
}

/// What covers a doubt is told, and does not grow from scan to scan.
void SlamEngine::remember(const ScanInput& input, const MotionPrediction& predicted, bool jumped,
                          const ScanOutcome& outcome) {
  const bool is_doubted = outcome.certainty == Certainty::kDoubtful;
  const Eigen::Matrix3d covariance = is_doubted ? predicted.covariance : outcome.covariance;
  if (jumped || is_doubted || outcome.certainty == Certainty::kSecondLook) {
    tracker_.distrust_odometry();
  } else if (outcome.match.accepted() && outcome.certainty == Certainty::kSure) {
    tracker_.learn(input, predicted, outcome.match);
  }
  tracker_.remember(input, predicted, outcome.map_from_base,
                    outcome.inserted ? beside_drawn(covariance) : covariance,
                    outcome.match.accepted() || outcome.inserted);
  if (jumped) {
    tracker_.forget_motion();  // from where it was wrongly thought to be there is none
  }
}

void SlamEngine::close_loops(ScanOutcome& outcome) {
  if (mapping_.is_lost() || !mapping_.closes_loops(options_)) {
    return;
  }
  outcome.corrected = mapping_.close_loops(options_);
  if (outcome.corrected) {
    const Pose2& new_from_old = outcome.corrected->newest;
    tracker_.change_frame(new_from_old);
    outcome.map_from_base = new_from_old * outcome.map_from_base;
    outcome.predicted_map_from_base = new_from_old * outcome.predicted_map_from_base;
  }
}

std::optional<MapCorrection> SlamEngine::finish_loops() {
  std::optional<MapCorrection> correction = mapping_.finish_loops();
  mapping_.catch_up(options_);
  if (correction) {
    tracker_.change_frame(correction->newest);
  }
  return correction;
}

bool SlamEngine::maps_on() const {
  return mapping_.closes_loops(options_) && options_.slam.update_map && !mapping_.is_lost();
}

TrackingState SlamEngine::state() const {
  if (mapping_.is_lost()) {
    return TrackingState::kLost;
  }
  if (const TrackingDoubt& doubt = tracking_.doubt(); doubt.doubts) {
    return doubt.is_provisional ? TrackingState::kProvisional : TrackingState::kDoubt;
  }
  return mapping_.has_pending(options_) ? TrackingState::kRecovered : TrackingState::kTracking;
}

// --- where the robot is ---

bool SlamEngine::map_apart(double stamp) {
  constexpr double kDrawn = 0.003;  // [s] a key scan; what is searched is drawn meanwhile
  tracking_.believe();
  // Nor is it known how it moves: the next two matches will tell.
  tracker_.set_pose(tracker_.state().fixed_from_base, tracker_.state().covariance);
  const Mapping::BegunApart begun = mapping_.begin_apart(stamp, options_);
  // Where another part had just begun, the drawing that was for that one is still under way.
  const double since = begun.is_drawn_beside
                           ? stamp + kDrawn * static_cast<double>(key_scans().size())
                           : places_.search().stamp;
  places_.begin(mapping_.parts(), since);
  return begun.gave_up_part;
}

void SlamEngine::search_for_map(const SearchStep& step, ScanOutcome& outcome) {
  if (!places_.has_begun(outcome.stamp)) {
    return;
  }
  static_cast<void>(map());
  const std::optional<PlaceHypothesis> found =
      places_.find(seen_->all(), outcome.map_from_base, step, mapping_.parts(), options_);
  if (!found) {
    return;
  }
  const double begin = mapping_.parts().here().begin;
  join(*found);
  outcome.joined = ScanOutcome::Joined{begin, found->part_from_apart};
  outcome.map_from_base = tracker_.state().fixed_from_base;
  outcome.predicted_map_from_base = found->part_from_apart * outcome.predicted_map_from_base;
  // How well the place was confirmed: [m], [rad]. Guesses; half or double changes no byte of six
  // drives with faults (benchmark/reports/current/CONSTANTS.md).
  constexpr double kXy = 0.1;
  constexpr double kTheta = 0.05;
  outcome.covariance = tracker_.state().covariance + covariance_of(kXy, kTheta);
}

/// Puts what was mapped apart where it belongs, a few key scans with each of the next scans.
void SlamEngine::join(const PlaceHypothesis& found) {
  tracker_.change_frame(found.part_from_apart);
  mapping_.join(found.part, found.part_from_apart, options_);
  tracking_.believe();
  places_.begin(mapping_.parts());
}

void SlamEngine::set_pose(const Pose2& map_from_base, const Eigen::Matrix3d& covariance) {
  tracker_.set_pose(map_from_base, covariance);
  mapping_.go_to_map(options_);
  tracking_.believe();
  places_.begin(mapping_.parts());
}

// --- options, and going on from elsewhere ---

void SlamEngine::set_options(const EngineOptions& options) {
  check_map(mapping_.parts().map().map, options);
  options_ = options;
  tracker_.set_options(options.motion);
  if (!options.doubt.enabled) {
    tracking_.believe();
  }
  mapping_.set_options(options);
}

void SlamEngine::start_from(MapStart start) {
  check_maps(start, options_);
  Whereabouts& whereabouts = start.whereabouts;
  std::vector<MapPart> parts{
      {std::move(start.map), std::move(start.key_scans), std::move(start.last_inserted), 0.0}};
  std::move(whereabouts.apart.begin(), whereabouts.apart.end(), std::back_inserter(parts));
  const std::size_t drawn = parts.front().key_scans.size();
  mapping_ = Mapping(MapParts(std::move(parts), whereabouts.here, std::move(whereabouts.pending)),
                     std::move(start.loops), {std::move(start.near_map), start.is_moved, drawn},
                     start.is_continued, start.is_of_key_scans, options_);
  tracking_ = Tracking(whereabouts.doubt, whereabouts.usual_score, whereabouts.contradicted_way,
                       std::move(whereabouts.held));
  places_ = PlaceFinder(std::move(whereabouts.search), mapping_.parts());
  tracker_.set_state(start.motion);
  scan_count_ = start.scan_count;
  further_lasers_ = std::move(start.further_lasers);
}

std::size_t SlamEngine::map_bytes() const {
  const SlamMap& map = mapping_.parts().map().map;
  return map.occupancy.bytes() + map.field.bytes();
}

MapStart SlamEngine::snapshot() {
  static_cast<void>(drawn_map());
  const MapParts& parts = mapping_.parts();
  return {parts.map().map,
          parts.map().key_scans,
          tracker_.state(),
          parts.map().last_inserted,
          scan_count_,
          {tracking_.doubt(),
           tracking_.usual_score(),
           tracking_.contradicted_way(),
           tracking_.held(),
           parts.waiting(),
           {parts.all().begin() + 1, parts.all().end()},
           parts.here_number(),
           places_.search()},
          mapping_.loops(),
          mapping_.drawing().near(),
          mapping_.drawing().is_moved(),
          mapping_.is_continued(),
          mapping_.is_of_key_scans(),
          further_lasers_};
}

}  // namespace matchbox_slam
