#include "matchbox_slam/slam/slam_engine.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

/// Throws ConfigurationError when the map was not made with these options.
void check_map(const SlamMap& map, const EngineOptions& options) {
  const auto require = [](const std::string& name, double wanted, double made) {
    if (wanted != made) {
      throw ConfigurationError(name + ": " + to_string(wanted) +
                               " is not allowed with a map that was made with " + to_string(made) +
                               "; allowed: the same, or a new map");
    }
  };
  require("map/resolution", options.map.resolution, map.field.geometry().resolution());
  require("field/sigma", options.field.sigma, map.field.options().sigma);
  require("field/reach", options.field.reach, map.field.options().reach);
}

MapPart empty_part(const EngineOptions& options, double begin) {
  return {SlamMap(options.map, options.field), {}, {}, begin};
}

/// What waited is about where it is said to be; where the map holds it, that knows better.
Pose2 placed_best(const PointScan& scan, const Pose2& map_from_base, const LikelihoodField& field,
                  const DoubtOptions& options) {
  constexpr double kXy = 0.1;      // [m]
  constexpr double kTheta = 0.03;  // [rad]
  const PlacedScans none;
  const MatchResult match = search_exactly(
      {scan, map_from_base, Eigen::Vector3d(kXy * kXy, kXy * kXy, kTheta * kTheta).asDiagonal(),
       field, none, 0});
  return is_convincing(match, options) ? match.map_from_base : map_from_base;
}

/// A lost robot may be anywhere in the map, in any heading.
Eigen::Matrix3d anywhere_in(const SlamMap& map) {
  const CellBox box = map.occupancy.known_bounds();
  const double size = map.field.geometry().resolution() * std::hypot(box.width(), box.height());
  return Eigen::Vector3d(size * size, size * size, kPi * kPi).asDiagonal();
}

}  // namespace

void MapStart::begin_anew(const Pose2& map_from_base, const Eigen::Matrix3d& covariance) {
  MotionState at_rest;  // made first: the arguments may be the present motion's own
  at_rest.fixed_from_base = map_from_base;
  at_rest.covariance = covariance;
  motion = at_rest;
  last_inserted.clear();
  whereabouts.doubt = {};
  whereabouts.usual_score = 0.0;
  whereabouts.held.clear();
  whereabouts.here = 0;
  whereabouts.search = {};
  near_map.clear();
  is_moved = false;
  is_continued = false;
}

SlamEngine::SlamEngine(const EngineOptions& options, std::shared_ptr<const ScanMatcher> matcher,
                       std::uint64_t seed, const Pose2& start)
    : options_(options),
      matcher_(std::move(matcher)),
      seed_(seed),
      tracker_(options.motion),
      parts_{empty_part(options, 0.0)} {
  tracker_.set_pose(start, Eigen::Matrix3d::Zero());
}

ScanOutcome SlamEngine::process(const ScanInput& input) {
  const MotionPrediction predicted = tracker_.predict(input);
  MeasuredScan measured{input.scan, input.base_from_laser, predicted.during_scan, options_.scan};
  PointScan scan = project_scan(measured);

  // A rejected match carries the prediction, which stands then.
  ScanOutcome outcome;
  const WeighedMatch weighed = match(scan, predicted);
  outcome.match = weighed.match;
  outcome.certainty = weighed.certainty;
  const MatchedMotion matched = tracker_.after_match(input, predicted, outcome.match);
  outcome.stamp = input.scan.stamp;
  outcome.map_from_base = matched.fixed_from_base;
  outcome.covariance = outcome.match.covariance;
  outcome.predicted_map_from_base = predicted.fixed_from_base;
  if (input.odometry) {
    outcome.odom_from_base = input.odometry->odom_from_base;
  }
  weigh_doubt(weighed, outcome, predicted.motion.previous_from_current.translation().norm());
  if (options_.slam.loop_closing && options_.slam.update_map && !is_lost() &&
      doubt_.is_blind(options_.tracking)) {
    // Nothing says that it is elsewhere. How badly it is known where, the graph is told.
    doubt_ = {};
    outcome.certainty = Certainty::kNewGround;
    outcome.covariance = predicted.covariance;
  }

  if (is_to_be_inserted(outcome, input.laser)) {
    if (matched.during_scan != predicted.during_scan) {
      measured.motion = matched.during_scan;
      scan = project_scan(measured);
    }
    insert_or_hold(scan, measured, input.laser, outcome);
  }
  // What covers a doubt is told, and does not grow from scan to scan.
  const bool is_doubted = outcome.certainty == Certainty::kDoubtful;
  tracker_.remember(input, predicted, outcome.map_from_base,
                    is_doubted ? predicted.covariance : outcome.covariance,
                    outcome.match.accepted() || outcome.inserted);
  ++scan_count_;
  if (!is_lost() && outcome.inserted && options_.slam.loop_closing) {
    close_loops(outcome);
  }
  outcome.left_out += insert_pending();
  if (doubt_.is_lost(input.scan.stamp, options_.tracking)) {
    outcome.gave_up_part = map_apart();
  } else if (is_lost() && outcome.match.accepted()) {
    search_for_map(scan, outcome);
  }
  if (is_lost()) {
    outcome.covariance += anywhere_in(parts_.front().map);
  }
  outcome.state = state();
  return outcome;
}

WeighedMatch SlamEngine::match(const PointScan& scan, const MotionPrediction& predicted) const {
  const MapPart& part = here();
  const SlamMap& map = !is_lost() && near_map_.map() != nullptr ? *near_map_.map() : part.map;
  const PlacedScans recent =
      part.key_scans.newest(static_cast<std::size_t>(options_.slam.recent_scans));
  const MatchProblem problem{scan,   predicted.fixed_from_base,   predicted.covariance, map.field,
                             recent, mix_seed(seed_, scan_count_)};
  if (map.field.empty()) {
    return {rejected(problem, MatchStatus::kRejectedNoReference)};
  }
  if (scan.points.size() < static_cast<std::size_t>(options_.slam.min_points)) {
    return {rejected(problem, MatchStatus::kRejectedTooFewPoints)};
  }
  return match_and_weigh(*matcher_, problem, map.occupancy, {usual_score_, doubt_.doubts},
                         options_.doubt);
}

TrackingState SlamEngine::state() const {
  if (is_lost()) {
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
  if (match.match.accepted()) {
    usual_score_ += (usual_score_ > 0.0 ? kNewest : 1.0) * (match.match.score - usual_score_);
  }
  const bool was_provisional = doubt_.is_provisional;
  doubt_.follow(match, outcome.stamp, way, outcome.map_from_base, options_.doubt,
                options_.tracking);
  // What was held before a jump lies where the robot is not.
  if (doubt_.is_provisional && was_provisional && !match.jumped) {
    return;
  }
  if (!doubt_.doubts) {
    pending_.insert(pending_.end(), held_.begin(), held_.end());
  } else if (!held_.empty()) {
    here().last_inserted.clear();  // of scans that are dropped
  }
  held_.clear();
}

/// The robot may be anywhere. What it sees from now on is mapped apart. Returns whether another map
/// apart had to be given up for that.
bool SlamEngine::map_apart() {
  constexpr std::size_t kWorthKeeping = 3;  // key scans
  doubt_ = {};
  held_.clear();
  search_ = {};
  // Nor is it known how it moves: the next two matches will tell.
  tracker_.set_pose(tracker_.state().fixed_from_base, tracker_.state().covariance);
  near_map_.clear();
  match_whole_map();
  if (is_lost() && here().key_scans.size() < kWorthKeeping) {
    MapPart anew = empty_part(options_, here().begin);
    anew.left = here().left;
    anew.left_from_here = here().left_from_here;
    here() = std::move(anew);
    pending_.erase(std::remove_if(pending_.begin(), pending_.end(),
                                  [this](const WaitingScan& scan) { return scan.part == here_; }),
                   pending_.end());
  } else {
    parts_.push_back(empty_part(options_, *tracker_.state().stamp));
    parts_.back().left = here_;
    here_ = parts_.size() - 1;
  }
  const bool are_too_many = parts_apart() > kMostPartsApart;
  if (are_too_many) {
    give_up_smallest_part();
  }
  find_places_to_search();
  return are_too_many;
}

/// Of those that the robot is not in, with what waits for it.
void SlamEngine::give_up_smallest_part() {
  const auto smallest = std::min_element(
      parts_.begin() + 1, parts_.end() - 1,
      [](const auto& a, const auto& b) { return a.key_scans.size() < b.key_scans.size(); });
  const auto part = static_cast<std::size_t>(smallest - parts_.begin());
  std::vector<WaitingScan> pending;
  for (const WaitingScan& waiting : pending_) {
    if (waiting.part != part) {
      pending.push_back({waiting.part - (waiting.part > part ? 1 : 0), waiting.scan});
    }
  }
  pending_ = std::move(pending);
  remove_part(part, smallest->left, smallest->left_from_here, parts_);
  here_ = parts_.size() - 1;
}

void SlamEngine::find_places_to_search() {
  places_.clear();
  if (is_lost()) {
    places_ = searched_places(parts_, here_);
  }
}

void SlamEngine::search_for_map(const PointScan& scan, ScanOutcome& outcome) {
  const std::optional<PlaceHypothesis> found =
      search_places(scan, outcome.map_from_base, parts_, here_, places_, options_.doubt,
                    options_.recovery, search_);
  if (!found) {
    return;
  }
  const double begin = here().begin;
  join(*found);
  outcome.joined = ScanOutcome::Joined{begin, found->part_from_apart};
  outcome.map_from_base = tracker_.state().fixed_from_base;
  outcome.predicted_map_from_base = found->part_from_apart * outcome.predicted_map_from_base;
  // How well the place was confirmed: [m], [rad].
  constexpr double kXy = 0.1;
  constexpr double kTheta = 0.05;
  outcome.covariance =
      tracker_.state().covariance +
      Eigen::Matrix3d(Eigen::Vector3d(kXy * kXy, kXy * kXy, kTheta * kTheta).asDiagonal());
}

/// Puts what was mapped apart where it belongs, a few key scans with each of the next scans.
void SlamEngine::join(const PlaceHypothesis& found) {
  const std::size_t apart = here_;
  const double begin = here().begin;
  const auto part_without = [&](std::size_t part) { return part > apart ? part - 1 : part; };
  for (WaitingScan& waiting : pending_) {
    if (waiting.part == apart) {
      waiting = {found.part,
                 {waiting.scan.scan, found.part_from_apart * waiting.scan.map_from_base}};
    }
    waiting.part = part_without(waiting.part);
  }
  const std::size_t joined = part_without(found.part);
  if (options_.slam.update_map) {
    for (const PlacedScan& key : here().key_scans.all()) {
      pending_.push_back({joined, {key.scan, found.part_from_apart * key.map_from_base}});
    }
  }
  tracker_.change_frame(found.part_from_apart);
  remove_part(apart, found.part, found.part_from_apart, parts_);
  here_ = joined;
  here().begin = std::min(here().begin, begin);
  here().last_inserted.clear();
  is_continued_ = false;
  leave_parts_if_found();
  doubt_ = {};
  held_.clear();
  search_ = {};
  find_places_to_search();
}

/// Poses that were taken in parts that the robot is not in any more are not to be put right later:
/// others have come after them.
void SlamEngine::leave_parts_if_found() {
  constexpr double kNever = 1e15;  // [s]
  if (!is_lost()) {
    std::for_each(parts_.begin() + 1, parts_.end(), [](MapPart& part) { part.begin = kNever; });
  }
}

void SlamEngine::set_pose(const Pose2& map_from_base, const Eigen::Matrix3d& covariance) {
  tracker_.set_pose(map_from_base, covariance);
  here_ = 0;
  is_continued_ = false;
  near_map_.clear();
  match_whole_map();
  leave_parts_if_found();
  pending_.clear();
  doubt_ = {};
  held_.clear();
  search_ = {};
  places_.clear();
}

void SlamEngine::set_options(const EngineOptions& options) {
  check_map(parts_.front().map, options);
  options_ = options;
  tracker_.set_options(options.motion);
  if (!options.doubt.enabled) {
    doubt_ = {};
    held_.clear();
  }
  if (!options.slam.loop_closing) {
    near_map_.clear();
    match_whole_map();
  }
}

void SlamEngine::start_from(MapStart start) {
  check_map(start.map, options_);
  for (const MapPart& part : start.whereabouts.apart) {
    check_map(part.map, options_);
  }
  if (const SlamMap* near = start.near_map.map()) {
    check_map(*near, options_);
  }
  parts_.clear();
  parts_.push_back(
      {std::move(start.map), std::move(start.key_scans), std::move(start.last_inserted), 0.0});
  Whereabouts& whereabouts = start.whereabouts;
  std::move(whereabouts.apart.begin(), whereabouts.apart.end(), std::back_inserter(parts_));
  here_ = whereabouts.here;
  doubt_ = whereabouts.doubt;
  usual_score_ = whereabouts.usual_score;
  held_ = std::move(whereabouts.held);
  pending_ = std::move(whereabouts.pending);
  search_ = std::move(whereabouts.search);
  find_places_to_search();
  loops_ = std::move(start.loops);
  near_map_ = std::move(start.near_map);
  is_moved_ = start.is_moved;
  is_outdated_ = false;
  is_continued_ = start.is_continued;
  tracker_.set_state(start.motion);
  scan_count_ = start.scan_count;
}

const SlamMap& SlamEngine::map() {
  if (is_outdated_) {
    parts_.front().map = rendered(key_scans().all(), options_.map, options_.field);
    is_outdated_ = false;
  }
  return parts_.front().map;
}

void SlamEngine::match_whole_map() {
  static_cast<void>(map());
  is_moved_ = false;
}

MapStart SlamEngine::snapshot() {
  static_cast<void>(map());
  const MapPart& part = parts_.front();
  return {
      part.map,
      part.key_scans,
      tracker_.state(),
      part.last_inserted,
      scan_count_,
      {doubt_, usual_score_, held_, pending_, {parts_.begin() + 1, parts_.end()}, here_, search_},
      loops_,
      near_map_,
      is_moved_,
      is_continued_};
}

// --- loops ---

/// With the newest scan, which was inserted.
void SlamEngine::close_loops(ScanOutcome& outcome) {
  const PlacedScans& keys = key_scans().all();
  if (const std::optional<MapCorrection> found = loops_.search(key_scans(), options_.loops)) {
    move_map(*found, outcome);
  }
  near_map_.add(keys, loops_.apart(options_.loops), is_moved_, options_.map, options_.field);
}

void SlamEngine::move_map(const MapCorrection& correction, ScanOutcome& outcome) {
  MapPart& part = parts_.front();
  for (std::size_t i = 0; i < part.key_scans.size(); ++i) {
    part.key_scans.move(i, loops_.graph().poses[i]);
  }
  const Pose2& here = correction.newest;
  for (WaitingScan& waiting : pending_) {
    if (waiting.part == 0) {
      waiting.scan.map_from_base = here * waiting.scan.map_from_base;
    }
  }
  for (auto& [laser, map_from_base] : part.last_inserted) {
    map_from_base = here * map_from_base;
  }
  tracker_.change_frame(here);
  outcome.map_from_base = here * outcome.map_from_base;
  outcome.predicted_map_from_base = here * outcome.predicted_map_from_base;
  outcome.corrected = correction;
  if (correction.most_moved > 0.5 * options_.map.resolution) {
    near_map_.clear();
    is_moved_ = true;
  }
  is_outdated_ = is_moved_;  // by little, too, whether or not it was rendered in between
}

// --- insertion ---

/// Only what was matched without a doubt goes into the map, except for what starts it. A further
/// laser's first scan may show what no other has seen yet: then it goes where the others have just
/// put the base.
bool SlamEngine::is_to_be_inserted(const ScanOutcome& outcome, int laser) const {
  const MatchResult& match = outcome.match;
  if (!options_.slam.update_map && !is_lost()) {
    return false;
  }
  if (match.accepted() || outcome.certainty == Certainty::kNewGround) {
    return is_worth_inserting(outcome, laser);
  }
  const MapPart& part = here();
  return part.map.field.empty() ||
         (match.status == MatchStatus::kRejectedLowScore && tracker_.state().matched &&
          !part.last_inserted.empty() && part.last_inserted.count(laser) == 0);
}

bool SlamEngine::is_worth_inserting(const ScanOutcome& outcome, int laser) const {
  const std::map<int, Pose2>& last_inserted = here().last_inserted;
  const auto before = last_inserted.find(laser);
  if (before == last_inserted.end()) {
    return true;
  }
  const Pose2 moved = before->second.inverse() * outcome.map_from_base;
  return moved.translation().norm() >= options_.slam.insert_distance ||
         std::abs(moved.theta) >= options_.slam.insert_angle ||
         outcome.match.score < options_.slam.insert_overlap;
}

void SlamEngine::insert_or_hold(const PointScan& scan, const MeasuredScan& measured, int laser,
                                ScanOutcome& outcome) {
  const PlacedScan placed{std::make_shared<const KeyScan>(measured, 0, laser),
                          outcome.map_from_base};
  if (doubt_.doubts) {
    if (doubt_.is_provisional) {
      held_.push_back({here_, placed});
      here().last_inserted[laser] = outcome.map_from_base;
    }
    return;
  }
  outcome.inserted = insert(scan, placed, outcome.covariance, is_continued_, here());
  is_continued_ = true;
  outcome.left_out = outcome.inserted ? 0 : 1;
}

/// False when the map has no room for it.
bool SlamEngine::insert(const PointScan& scan, const PlacedScan& placed,
                        const Eigen::Matrix3d& covariance, bool is_continued, MapPart& part) {
  if (!has_room(scan, placed.map_from_base, options_.map, part.map)) {
    return false;
  }
  const bool is_map = &part == &parts_.front();
  if (!is_map || !is_outdated_) {
    insert_scan(scan, placed.map_from_base, options_.map, part.map);
  }
  part.key_scans.add(placed);
  if (is_map && options_.slam.loop_closing) {
    loops_.add(part.key_scans, covariance, is_continued, options_.loops);
  }
  part.last_inserted[placed.scan->laser()] = placed.map_from_base;
  return true;
}

/// Whether something waits that may be inserted into the part that the robot is in.
bool SlamEngine::has_pending() const {
  return (options_.slam.update_map || is_lost()) &&
         std::any_of(pending_.begin(), pending_.end(),
                     [this](const WaitingScan& waiting) { return waiting.part == here_; });
}

/// What waits is no surer than where the robot is. Returns how many scans the map has no room for.
std::size_t SlamEngine::insert_pending() {
  constexpr int kAtATime = 2;      // so that no scan waits for all of them
  constexpr double kXy = 0.05;     // [m]
  constexpr double kTheta = 0.02;  // [rad]
  if (is_moved_ && has_pending()) {
    match_whole_map();
  }
  MapPart& part = here();
  std::size_t left_out = 0;
  for (int i = 0; i < kAtATime && !doubt_.doubts && has_pending(); ++i) {
    const auto waiting =
        std::find_if(pending_.begin(), pending_.end(),
                     [this](const WaitingScan& scan) { return scan.part == here_; });
    const std::shared_ptr<const PointScan> points = waiting->scan.scan->points();
    const PlacedScan placed{waiting->scan.scan, placed_best(*points, waiting->scan.map_from_base,
                                                            part.map.field, options_.doubt)};
    const std::map<int, Pose2> last_inserted = part.last_inserted;
    const Eigen::Matrix3d covariance =
        Eigen::Vector3d(kXy * kXy, kXy * kXy, kTheta * kTheta).asDiagonal();
    left_out += insert(*points, placed, covariance, false, part) ? 0 : 1;
    is_continued_ = false;
    part.last_inserted = last_inserted;
    pending_.erase(waiting);
  }
  return left_out;
}

}  // namespace matchbox_slam
