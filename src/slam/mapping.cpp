#include "slam/mapping.hpp"

#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matching/rendered_map.hpp"
#include "slam/found_map.hpp"
#include "slam/local_map.hpp"
#include "slam/scan_evidence.hpp"
#include "slam/superfluous_scans.hpp"

namespace matchbox_slam {
namespace {

MapComponent empty_component(const EngineOptions& options, double begin) {
  return {SlamMap(options.map, options.field), {}, {}, begin};
}

}  // namespace

Eigen::Matrix3d covariance_of_waiting() {
  constexpr double kSigmaXy = 0.05;     // [m], a cell: a guess
  constexpr double kSigmaTheta = 0.02;  // [rad], a point 2.5 m away by a cell
  return covariance_of(kSigmaXy, kSigmaTheta);
}

Mapping::Mapping(const EngineOptions& options)
    : options_(options), components_({empty_component(options, 0.0)}) {}

Mapping::Mapping(MapComponents components, LoopCloser loops, MapRenderer drawing, bool is_continued,
                 bool is_of_key_scans, const EngineOptions& options)
    : options_(options),
      components_(std::move(components)),
      loops_(std::move(loops)),
      renderer_(std::move(drawing)),
      is_continued_(is_continued),
      is_of_key_scans_(is_of_key_scans) {
  loops_.begin_again(components_.map().key_scans, renderer_.local_map(), options);
  match_as();
}

bool Mapping::has_pending() const {
  return (options_.slam.update_map || is_lost()) && components_.next_waiting() != nullptr;
}

const SlamMap& Mapping::matched() const {
  if (is_lost()) {
    return components_.active().map;
  }
  return temporary_.map() != nullptr ? *temporary_.map() : lasting();
}

void Mapping::take_rendered(SlamMap map, const PlacedScans& keys) {
  renderer_.take_rendered(std::move(map), keys, components_.map());
}

// --- scans ---

bool Mapping::insert(const PointScan& points, const PlacedScan& placed,
                     const Eigen::Matrix3d& covariance) {
  const bool is_inserted = add(points, placed, covariance, is_continued_);
  is_continued_ = is_continued_ || is_inserted;
  return is_inserted;
}

void Mapping::draw_over(const PointScan& points, int laser, const Pose2& map_from_base) {
  if (has_room(points, map_from_base, options_.map, matched())) {
    temporary_.add(points, laser, map_from_base, lasting(), options_.map);
  }
}

bool Mapping::add(const PointScan& points, const PlacedScan& placed,
                  const Eigen::Matrix3d& covariance, bool is_continued) {
  MapComponent& component = components_.active();
  if (!has_room(points, placed.map_from_base, options_.map, component.map)) {
    return false;
  }
  if (is_lost()) {
    component.key_scans.add(placed);
    insert_scan(points, placed.map_from_base, options_.map, component.map);
  } else {
    renderer_.add(placed, points, component, options_);
    if (closes_loops()) {
      loops_.add(component.key_scans, covariance, is_continued, options_.loops);
    }
  }
  component.last_inserted[placed.scan->laser()] = placed.map_from_base;
  return true;
}

/// What waits is no surer than where the robot is.
std::size_t Mapping::insert_pending() {
  constexpr int kScansPerStep = 2;  // so that no scan waits for all of them
  std::size_t left_out = 0;
  for (int i = 0; i < kScansPerStep && has_pending(); ++i) {
    const PlacedScan waiting = components_.next_waiting()->scan;
    const std::shared_ptr<const PointScan> points = waiting.scan->points();
    components_.drop_next_waiting();
    if (is_badly_explained(evidence_of(*points, waiting.map_from_base, matched()))) {
      continue;  // as of one that was seen while the robot was carried
    }
    const std::map<int, Pose2> last_inserted = components_.active().last_inserted;
    const bool is_inserted = add(*points, waiting, covariance_of_waiting(), false);
    left_out += is_inserted ? 0 : 1;
    catch_up();
    break_off();
    components_.active().last_inserted = last_inserted;
  }
  return left_out;
}

// --- where the robot may be elsewhere ---

void Mapping::fork() {
  const MapComponent& component = components_.active();
  fork_ = Fork{component.key_scans.size(), component.last_inserted, component.map, renderer_};
}

const SlamMap& Mapping::compared() const {
  if (!fork_ || (!is_lost() && temporary_.map() != nullptr)) {
    return matched();  // nothing is drawn over the map since the fork
  }
  const SlamMap* near = fork_->drawing.local_map().map();
  return is_lost() || near == nullptr ? fork_->map : *near;
}

MapCorrection Mapping::move_since_fork(const std::vector<std::optional<Pose2>>& poses,
                                       const Pose2& new_from_old, double stamp) {
  MapComponent& component = components_.active();
  const std::size_t first = fork_->key_scans;
  MapCorrection correction{{{std::numeric_limits<double>::lowest(), {}}}, new_from_old};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) {
      const PlacedScan before = component.key_scans.all()[first + i];
      component.key_scans.move(first + i, *poses[i]);
      correction.steps.push_back(
          {before.scan->stamp(), *poses[i] * before.map_from_base.inverse()});
    }
  }
  correction.steps.push_back({stamp, new_from_old});
  for (auto& [laser, map_from_base] : component.last_inserted) {
    map_from_base = new_from_old * map_from_base;
  }
  component.map = fork_->map;
  renderer_ = fork_->drawing;
  temporary_.clear();
  match_as();
  if (!is_lost() && closes_loops()) {
    loops_.move_since(first, component.key_scans);
  }
  draw_since(first);
  break_off();
  return correction;
}

void Mapping::draw_since(std::size_t key_scan) {
  if (!is_lost() && renderer_.local_map().map() != nullptr) {
    catch_up();
  } else if (!is_lost()) {
    static_cast<void>(whole());
  } else {
    MapComponent& component = components_.active();
    for (std::size_t i = key_scan; i < component.key_scans.size(); ++i) {
      const PlacedScan& key = component.key_scans.all()[i];
      insert_scan(*key.scan->points(), key.map_from_base, options_.map, component.map);
    }
  }
}

void Mapping::forget_since_fork() {
  if (!fork_) {
    return;
  }
  MapComponent& component = components_.active();
  component.map = fork_->map;
  renderer_ = fork_->drawing;
  temporary_.clear();
  component.key_scans.forget_since(fork_->key_scans);
  component.last_inserted = fork_->last_inserted;
  if (!is_lost()) {
    loops_.forget_since(fork_->key_scans);
  }
}

void Mapping::fork_as_of(std::size_t key_scans, std::map<int, Pose2> last_inserted) {
  const MapComponent& component = components_.active();
  const PlacedScans& keys = component.key_scans.all();
  fork_ = Fork{key_scans, std::move(last_inserted), component.map, renderer_};
  if (!is_lost() && !is_of_key_scans_) {
    return;  // walls that came without key scans cannot be drawn anew
  }
  if (!is_lost() && renderer_.local_map().map() != nullptr) {
    fork_->drawing.match_locally(
        renderer_.local_map().as_of(key_scans, keys, options_.map, options_.field));
    fork_->drawing.expect_redrawing();
    return;
  }
  const PlacedScans then(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(key_scans));
  fork_->map = rendered(then, options_.map, options_.field, MapUse::kShown);
  if (!is_lost()) {
    fork_->drawing = MapRenderer({}, renderer_.is_moved(), key_scans);
  }
}

// --- loops ---

LocalScans Mapping::scans_around() const {
  const KeyScans& key_scans = components_.map().key_scans;
  return local_scans(key_scans.all(), loops_.ways(key_scans), options_.loops.max_relative_sigma);
}

std::optional<MapCorrection> Mapping::close_loops() {
  const KeyScans& key_scans = components_.map().key_scans;
  std::optional<MapCorrection> correction;
  if (loops_.is_due(key_scans)) {
    correction = finish_loops();
  }
  if (!correction && found_ != nullptr && !loops_.is_pending() && !has_pending()) {
    correction = take_found_map();
  }
  const bool is_near_due = !loops_.is_pending() && renderer_.local_map().is_due(key_scans.all());
  if (is_near_due) {
    catch_up();  // so that what is begun goes on from a map of all key scans
  }
  LocalMapRequest near{std::nullopt, is_near_due ? renderer_.local_map() : LocalMap()};
  LocalScans scans = scans_around();
  if (is_crowded(key_scans.all(), static_cast<std::size_t>(options_.slam.enough_views))) {
    renderer_.expect_local_map();  // with which what is superfluous is found
  }
  if (!scans.apart.empty() || renderer_.is_moved()) {
    if (is_near_due) {
      near.scans = std::move(scans);
    }
  } else if (renderer_.local_map().map() != nullptr) {
    match_whole_map();
  }
  if (!has_pending()) {
    loops_.begin(key_scans, std::move(near), options_);
  }
  return correction;
}

/// What lies near is drawn at once, as the next scan is matched against it.
std::optional<MapCorrection> Mapping::take_found_map() {
  const std::shared_ptr<const FoundMap> found = std::exchange(found_, nullptr);
  KeyScans& key_scans = components_.map().key_scans;
  if (found->fate != FoundMap::Fate::kWaiting) {
    return std::nullopt;
  }
  // A loop that moves nothing adds an edge all the same.
  const LoopState& state = loops_.state();
  if (state.nodes != key_scans.size() || state.loops.size() != found->loops ||
      !begins_with(key_scans.all(), found->own)) {
    found->fate = FoundMap::Fate::kOutdated;
    return std::nullopt;
  }
  MapCorrection correction = loops_.take_in(*found, key_scans);
  move_with_map(correction.newest);
  renderer_.match_locally(LocalMap(scans_around(), options_.map, options_.field));
  found->fate = FoundMap::Fate::kTaken;
  return correction;
}

std::optional<MapCorrection> Mapping::finish_loops() {
  if (!loops_.is_pending() || fork_) {
    return std::nullopt;  // nothing moves until it is decided where the robot is
  }
  LoopCloser::Result result = loops_.finish(components_.map().key_scans);
  if (result.near) {
    renderer_.match_locally(std::move(*result.near));
  }
  if (result.correction) {
    move_with_map(result.correction->newest);
  }
  take_out(result.superfluous);
  return result.correction;
}

void Mapping::take_out(const std::vector<std::uint64_t>& ids) {
  KeyScans& key_scans = components_.map().key_scans;
  if (ids.empty() || loops_.state().nodes != key_scans.size()) {
    return;
  }
  std::vector<bool> is_taken(key_scans.size(), false);
  for (const std::uint64_t id : ids) {
    is_taken.at(id) = true;
  }
  renderer_.renumber(loops_.take_out(is_taken, key_scans), ids.size());
}

void Mapping::move_with_map(const Pose2& new_from_old) {
  renderer_.expect_move();
  components_.move_waiting_for_map(new_from_old);
  for (auto& [laser, map_from_base] : components_.map().last_inserted) {
    map_from_base = new_from_old * map_from_base;
  }
}

void Mapping::set_options(const EngineOptions& options) {
  options_ = options;
  temporary_.clear();
  loops_.abandon();
  match_as();
}

/// What does not change, or has no graph that tells what belongs together, is matched as a whole.
void Mapping::match_as() {
  if (!closes_loops() || !options_.slam.update_map) {
    match_whole_map();
  }
}

// --- where the robot is ---

void Mapping::go_to_map() {
  temporary_.clear();
  components_.go_to_map();
  break_off();
  loops_.abandon();
  match_whole_map();
}

Mapping::BegunComponent Mapping::begin_component(double stamp) {
  loops_.abandon();
  temporary_.clear();
  BegunComponent begun;
  begun.is_drawn_beside = renderer_.begin_whole(components_.map(), options_);
  begun.gave_up_component = components_.begin_component(empty_component(options_, stamp));
  return begun;
}

void Mapping::join(std::size_t component, const Pose2& component_from_active) {
  components_.join(component, component_from_active, options_.slam.update_map);
  break_off();
}

}  // namespace matchbox_slam
