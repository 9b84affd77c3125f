#include "matchbox_slam/slam/slam_engine.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "slam/insertion.hpp"
#include "slam/seen_scans.hpp"

namespace matchbox_slam {
namespace {

MapPart empty_part(const EngineOptions& options, double begin) {
  return {SlamMap(options.map, options.field), {}, {}, begin};
}

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

/// How well it is known where a place of the map lies as seen from where the map began: what lies
/// farther away hangs on it by a heading that is known no better. Of 65 drives through 20 offices,
/// in four rows of faults, the mean normalised error squared is 1.6 to 3.0 with it, where 3 is
/// honest, and 3.0 to 5.3 without.
Eigen::Matrix3d bend_at(const Pose2& map_from_base, const KeyScans& key_scans) {
  constexpr double kBend = 1e-4;  // [rad]
  const double away =
      (map_from_base.translation() - key_scans.all().front().map_from_base.translation()).norm();
  return covariance_of(kBend * away, kBend);
}

/// A lost robot may be anywhere in the map, in any heading.
Eigen::Matrix3d anywhere_in(const SlamMap& map) {
  const CellBox box = map.occupancy.known_bounds();
  const double size = map.field.geometry().resolution() * std::hypot(box.width(), box.height());
  return covariance_of(size, kPi);
}

/// How well it is known where a robot is as seen from what it has just drawn, which lies as wrong
/// as the robot is: in a corridor that does not hold it the way since then counts alone. Else the
/// next matches may slide along it by all that has come together on its way. 24 drives of four
/// minutes through hotels and campuses, of 181 to 1040 beams that reach 6 to 30 m: mean error 0.19
/// m, median 0.058, and 0.35 and 0.071 without it. With 0.3 m one drive of few beams ends 5.9 m
/// off.
Eigen::Matrix3d beside_drawn(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d drawn = covariance_of(0.15, 0.05);  // [m], [rad]
  const Eigen::Matrix3d beside = covariance * (covariance + drawn).inverse() * drawn;
  return 0.5 * (beside + beside.transpose());
}

/// Whether a match with the prediction of a steady motion is to be believed and not that with the
/// prediction of an odometry which says what robots cannot do.
bool is_likelier(const WeighedMatch& steady, const WeighedMatch& by_odometry,
                 const DoubtOptions& options) {
  constexpr double kClearly = 0.1;  // as a second look has to
  return is_convincing(steady.match, options) &&
         (!by_odometry.match.accepted() ||
          net_score(steady.match) > net_score(by_odometry.match) + kClearly);
}

}  // namespace

SlamEngine::SlamEngine(const EngineOptions& options, std::shared_ptr<const ScanMatcher> matcher,
                       std::uint64_t seed, const Pose2& start)
    : options_(options),
      matcher_(std::move(matcher)),
      seed_(seed),
      tracker_(options.motion),
      parts_({empty_part(options, 0.0)}),
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
  const std::optional<MotionPrediction> steady = tracker_.predict_steadily(input);
  see(input, predicted, !steady);
  const WeighedMatch weighed = match_likeliest(steady, predicted);
  // A rejected match carries the prediction, which stands then.
  ScanOutcome outcome = outcome_of(input, predicted);
  outcome.match = weighed.match;
  outcome.certainty = weighed.certainty;
  const MatchedMotion matched = tracker_.after_match(input, predicted, outcome.match);
  outcome.map_from_base = matched.fixed_from_base;
  outcome.covariance = outcome.match.covariance;
  weigh_doubt(weighed, outcome, predicted.motion.previous_from_current.translation().norm());
  if (closes_loops() && options_.slam.update_map && !parts_.is_lost() &&
      doubt_.is_blind(options_.tracking)) {
    // Nothing says that it is elsewhere. How badly it is known where, the graph is told.
    doubt_ = {};
    outcome.certainty = Certainty::kNewGround;
    outcome.covariance = predicted.covariance;
  }

  if (is_to_be_inserted(input, outcome, parts_, tracker_.state().matched, options_.slam)) {
    seen_->put_right(matched.during_scan, projector_);
    insert_or_hold(*seen_, input.laser, outcome);
  }
  // What covers a doubt is told, and does not grow from scan to scan.
  const bool is_doubted = outcome.certainty == Certainty::kDoubtful;
  const Eigen::Matrix3d covariance = is_doubted ? predicted.covariance : outcome.covariance;
  tracker_.remember(input, predicted, outcome.map_from_base,
                    outcome.inserted ? beside_drawn(covariance) : covariance,
                    outcome.match.accepted() || outcome.inserted);
  if (weighed.jumped) {
    tracker_.forget_motion();  // from where it was wrongly thought to be there is none
  }
  further_lasers_.move_on(before.inverse() * outcome.map_from_base);
  ++scan_count_;
  if (!parts_.is_lost() && outcome.inserted && closes_loops()) {
    close_loops(outcome);
  }
  outcome.left_out += insert_pending();
  if (doubt_.is_lost(input.scan.stamp, options_.tracking)) {
    outcome.gave_up_part = map_apart(input.scan.stamp);
  } else if (parts_.is_lost() && outcome.match.accepted()) {
    search_for_map(seen_->all(), outcome);
  }
  const KeyScans& here = parts_.here().key_scans;
  if (outcome.match.accepted() && options_.slam.update_map && !here.empty()) {
    // What it was matched with was drawn where scans were thought to be that were no surer.
    outcome.covariance += outcome.match.covariance + bend_at(outcome.map_from_base, here);
  }
  if (parts_.is_lost()) {
    outcome.covariance += anywhere_in(parts_.map().map);
  }
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

/// What a laser that does not lead sees: where it is is the prediction.
ScanOutcome SlamEngine::take_aside(const ScanInput& input, const MotionPrediction& predicted) {
  const MotionState& newest = tracker_.state();
  const Pose2 newest_from_base = newest.fixed_from_base.inverse() * predicted.fixed_from_base;
  if (newest.matched && !doubt_.doubts && !parts_.is_lost() &&
      further_lasers_.is_sample_due(input.laser, newest_from_base)) {
    const PointScan scan = project_scan(input.scan, input.base_from_laser, predicted.during_scan,
                                        options_.scan, input.laser_motion);
    further_lasers_.sample(input.laser, scan, predicted.fixed_from_base, newest_from_base,
                           newest.velocity(), key_scans().all(), options_.map, options_.field);
  }
  further_lasers_.wait(input, newest.velocity(), newest_from_base, predicted.during_scan,
                       options_.scan);
  ScanOutcome outcome = outcome_of(input, predicted);
  if (parts_.is_lost()) {
    outcome.covariance += anywhere_in(parts_.map().map);
  }
  outcome.match.map_from_base = predicted.fixed_from_base;
  outcome.match.covariance = predicted.covariance;
  outcome.match.status = MatchStatus::kOfFurtherLaser;
  outcome.state = state();
  return outcome;
}

/// Where odometry tells of a step that cannot be, the robot may have gone on as it did: then
/// `predicted` becomes that.
WeighedMatch SlamEngine::match_likeliest(const std::optional<MotionPrediction>& steady,
                                         MotionPrediction& predicted) {
  const WeighedMatch by_odometry = match(seen_->all(), predicted);
  if (!steady) {
    return by_odometry;
  }
  const WeighedMatch steadily = match(seen_->all(), *steady);
  if (!is_likelier(steadily, by_odometry, options_.doubt)) {
    return by_odometry;
  }
  predicted = *steady;
  return steadily;
}

WeighedMatch SlamEngine::match(const PointScan& scan, const MotionPrediction& predicted) {
  const MapPart& part = parts_.here();
  const SlamMap& map = matched_map();
  part.key_scans.copy_newest(static_cast<std::size_t>(options_.slam.recent_scans), recent_);
  const MatchProblem problem{scan,    predicted.fixed_from_base,   predicted.covariance, map.field,
                             recent_, mix_seed(seed_, scan_count_)};
  if (map.field.empty()) {
    return {rejected(problem, MatchStatus::kRejectedNoReference)};
  }
  if (scan.points.size() < static_cast<std::size_t>(options_.slam.min_points)) {
    return {rejected(problem, MatchStatus::kRejectedTooFewPoints)};
  }
  return match_and_weigh(*matcher_, problem, map.occupancy, {usual_score_, doubt_.doubts},
                         options_.doubt);
}

const SlamMap& SlamEngine::matched_map() const {
  return parts_.is_lost() ? parts_.here().map : drawing_.matched(parts_.map());
}

TrackingState SlamEngine::state() const {
  if (parts_.is_lost()) {
    return TrackingState::kLost;
  }
  if (doubt_.doubts) {
    return doubt_.is_provisional ? TrackingState::kProvisional : TrackingState::kDoubt;
  }
  return has_pending() ? TrackingState::kRecovered : TrackingState::kTracking;
}

// --- doubt ---

void SlamEngine::weigh_doubt(const WeighedMatch& match, const ScanOutcome& outcome, double way) {
  constexpr double kNewest = 0.1;  // weight of the newest score among those of late
  // What is found in doubt may be wrong, and fits less than it would elsewhere.
  if (match.match.accepted() && !doubt_.doubts && !match.jumped) {
    usual_score_ += (usual_score_ > 0.0 ? kNewest : 1.0) * (match.match.score - usual_score_);
  }
  is_continued_ = is_continued_ && !match.jumped;
  const bool was_provisional = doubt_.is_provisional;
  doubt_.pass(outcome.stamp - tracker_.state().stamp.value_or(outcome.stamp));
  doubt_.follow(match, outcome.stamp, way, outcome.map_from_base, options_.doubt,
                options_.tracking);
  // What was held before a jump lies where the robot is not.
  if (doubt_.is_provisional && was_provisional && !match.jumped) {
    return;
  }
  if (!doubt_.doubts) {
    parts_.wait(held_);
  } else if (!held_.empty()) {
    parts_.here().last_inserted.clear();  // of scans that are dropped
  }
  held_.clear();
}

/// Where the robot is thought to be now; what was held or searched for until now is dropped.
void SlamEngine::believe() {
  doubt_ = {};
  held_.clear();
  search_ = {};
}

bool SlamEngine::map_apart(double stamp) {
  believe();
  // Nor is it known how it moves: the next two matches will tell.
  tracker_.set_pose(tracker_.state().fixed_from_base, tracker_.state().covariance);
  loops_.abandon();
  if (drawing_.begin_whole(parts_.map(), options_)) {
    constexpr double kDrawn = 0.003;  // [s] a key scan; what is searched is drawn meanwhile
    search_.stamp = stamp + kDrawn * static_cast<double>(key_scans().size());
  }
  const bool gave_up_part = parts_.begin_apart(empty_part(options_, stamp));
  find_places_to_search();
  return gave_up_part;
}

void SlamEngine::find_places_to_search() {
  places_.clear();
  if (parts_.is_lost()) {
    places_ = searched_places(parts_.all(), parts_.here_number());
  }
}

void SlamEngine::search_for_map(const PointScan& scan, ScanOutcome& outcome) {
  if (outcome.stamp < search_.stamp) {
    return;
  }
  static_cast<void>(map());
  const std::optional<PlaceHypothesis> found =
      search_places(scan, outcome.map_from_base, parts_.all(), parts_.here_number(), places_,
                    options_.doubt, options_.recovery, search_);
  if (!found) {
    return;
  }
  const double begin = parts_.here().begin;
  join(*found);
  outcome.joined = ScanOutcome::Joined{begin, found->part_from_apart};
  outcome.map_from_base = tracker_.state().fixed_from_base;
  outcome.predicted_map_from_base = found->part_from_apart * outcome.predicted_map_from_base;
  // How well the place was confirmed: [m], [rad].
  constexpr double kXy = 0.1;
  constexpr double kTheta = 0.05;
  outcome.covariance = tracker_.state().covariance + covariance_of(kXy, kTheta);
}

/// Puts what was mapped apart where it belongs, a few key scans with each of the next scans.
void SlamEngine::join(const PlaceHypothesis& found) {
  tracker_.change_frame(found.part_from_apart);
  parts_.join(found.part, found.part_from_apart, options_.slam.update_map);
  is_continued_ = false;
  believe();
  find_places_to_search();
}

void SlamEngine::set_pose(const Pose2& map_from_base, const Eigen::Matrix3d& covariance) {
  tracker_.set_pose(map_from_base, covariance);
  parts_.go_to_map();
  is_continued_ = false;
  loops_.abandon();
  match_whole_map();
  believe();
  places_.clear();
}

void SlamEngine::set_options(const EngineOptions& options) {
  check_map(parts_.map().map, options);
  options_ = options;
  tracker_.set_options(options.motion);
  if (!options.doubt.enabled) {
    doubt_ = {};
    held_.clear();
  }
  loops_.abandon();
  if (!options.slam.loop_closing) {
    match_whole_map();
  }
}

void SlamEngine::start_from(MapStart start) {
  check_maps(start, options_);
  Whereabouts& whereabouts = start.whereabouts;
  std::vector<MapPart> parts{
      {std::move(start.map), std::move(start.key_scans), std::move(start.last_inserted), 0.0}};
  std::move(whereabouts.apart.begin(), whereabouts.apart.end(), std::back_inserter(parts));
  parts_ = MapParts(std::move(parts), whereabouts.here, std::move(whereabouts.pending));
  doubt_ = whereabouts.doubt;
  usual_score_ = whereabouts.usual_score;
  held_ = std::move(whereabouts.held);
  search_ = std::move(whereabouts.search);
  find_places_to_search();
  loops_ = std::move(start.loops);
  drawing_ = MapDrawing(std::move(start.near_map), start.is_moved, key_scans().size());
  is_of_key_scans_ = start.is_of_key_scans;
  is_continued_ = start.is_continued;
  tracker_.set_state(start.motion);
  scan_count_ = start.scan_count;
  further_lasers_ = std::move(start.further_lasers);
  loops_.begin_again(key_scans(), near_request(), options_.loops);
}

std::size_t SlamEngine::map_bytes() const {
  const SlamMap& map = parts_.map().map;
  return map.occupancy.bytes() + map.field.bytes();
}

MapStart SlamEngine::snapshot() {
  static_cast<void>(map());
  const MapPart& part = parts_.map();
  return {part.map,
          part.key_scans,
          tracker_.state(),
          part.last_inserted,
          scan_count_,
          {doubt_,
           usual_score_,
           held_,
           parts_.waiting(),
           {parts_.all().begin() + 1, parts_.all().end()},
           parts_.here_number(),
           search_},
          loops_,
          drawing_.near(),
          drawing_.is_moved(),
          is_continued_,
          is_of_key_scans_,
          further_lasers_};
}

// --- loops ---

/// With the newest scan, which was inserted.
void SlamEngine::close_loops(ScanOutcome& outcome) {
  const PlacedScans& keys = key_scans().all();
  if (loops_.is_due(key_scans())) {
    outcome.corrected = finish_loops();
    if (outcome.corrected) {
      const Pose2& new_from_old = outcome.corrected->newest;
      outcome.map_from_base = new_from_old * outcome.map_from_base;
      outcome.predicted_map_from_base = new_from_old * outcome.predicted_map_from_base;
    }
  }
  NearRequest near = near_request();
  const bool is_any_apart = near_scans(keys, loops_.apart(options_.loops)).is_any_apart;
  if (is_any_apart || drawing_.is_moved()) {
    near.is_due = drawing_.near().is_due(keys);
  } else if (drawing_.near().map() != nullptr) {
    match_whole_map();
  }
  if (!has_pending()) {
    loops_.begin(key_scans(), near, options_.loops);
  }
}

std::optional<MapCorrection> SlamEngine::finish_loops() {
  if (!loops_.is_pending()) {
    return std::nullopt;
  }
  LoopCloser::Result result = loops_.finish(key_scans());
  if (result.near) {
    drawing_.match_near(std::move(*result.near));
  }
  if (result.correction) {
    move_map(*result.correction);
  }
  drawing_.catch_up(parts_.map(), options_);
  return result.correction;
}

NearRequest SlamEngine::near_request() const { return {false, options_.map, options_.field}; }

void SlamEngine::move_map(const MapCorrection& correction) {
  MapPart& part = parts_.map();
  drawing_.expect_move();
  for (std::size_t i = 0; i < part.key_scans.size(); ++i) {
    part.key_scans.move(i, loops_.graph().poses[i]);
  }
  const Pose2& here = correction.newest;
  parts_.move_waiting_for_map(here);
  for (auto& [laser, map_from_base] : part.last_inserted) {
    map_from_base = here * map_from_base;
  }
  tracker_.change_frame(here);
}

// --- insertion ---

void SlamEngine::insert_or_hold(const SeenScans& seen, int laser, ScanOutcome& outcome) {
  insert_or_hold(seen.points(), seen.leading(), laser, outcome);
  for (const auto& [further, one] : seen.further()) {
    ScanOutcome beside = outcome;
    beside.map_from_base = outcome.map_from_base * one.there_from_base;
    insert_or_hold(project_scan(one.measured), one.measured, further, beside);
    outcome.left_out += beside.left_out;
  }
}

void SlamEngine::insert_or_hold(const PointScan& scan, const MeasuredScan& measured, int laser,
                                ScanOutcome& outcome) {
  const PlacedScan placed{std::make_shared<const KeyScan>(measured, 0, laser),
                          outcome.map_from_base};
  if (doubt_.doubts) {
    if (doubt_.is_provisional) {
      held_.push_back({parts_.here_number(), placed});
      parts_.here().last_inserted[laser] = outcome.map_from_base;
    }
    return;
  }
  outcome.inserted = insert(scan, placed, outcome.covariance, is_continued_, parts_.here());
  is_continued_ = true;
  outcome.left_out = outcome.inserted ? 0 : 1;
}

/// False when the map has no room for it.
bool SlamEngine::insert(const PointScan& scan, const PlacedScan& placed,
                        const Eigen::Matrix3d& covariance, bool is_continued, MapPart& part) {
  if (!has_room(scan, placed.map_from_base, options_.map, part.map)) {
    return false;
  }
  if (&part == &parts_.map()) {
    drawing_.add(placed, scan, part, options_);
    if (closes_loops()) {
      loops_.add(part.key_scans, covariance, is_continued, options_.loops);
    }
  } else {
    part.key_scans.add(placed);
    insert_scan(scan, placed.map_from_base, options_.map, part.map);
  }
  part.last_inserted[placed.scan->laser()] = placed.map_from_base;
  return true;
}

/// Whether something waits that may be inserted into the part that the robot is in.
bool SlamEngine::has_pending() const {
  return (options_.slam.update_map || parts_.is_lost()) && parts_.next_waiting() != nullptr;
}

/// What waits is no surer than where the robot is. Returns how many scans the map has no room for.
std::size_t SlamEngine::insert_pending() {
  constexpr int kAtATime = 2;      // so that no scan waits for all of them
  constexpr double kXy = 0.05;     // [m]
  constexpr double kTheta = 0.02;  // [rad]
  MapPart& part = parts_.here();
  std::size_t left_out = 0;
  for (int i = 0; i < kAtATime && !doubt_.doubts && has_pending(); ++i) {
    const PlacedScan waiting = parts_.next_waiting()->scan;
    const std::shared_ptr<const PointScan> points = waiting.scan->points();
    const std::optional<Pose2> map_from_base =
        placed_best(*points, waiting.map_from_base, matched_map(), options_.doubt);
    parts_.drop_next_waiting();
    if (!map_from_base) {
      continue;
    }
    const PlacedScan placed{waiting.scan, *map_from_base};
    const std::map<int, Pose2> last_inserted = part.last_inserted;
    left_out += insert(*points, placed, covariance_of(kXy, kTheta), false, part) ? 0 : 1;
    is_continued_ = false;
    part.last_inserted = last_inserted;
  }
  return left_out;
}

}  // namespace matchbox_slam
