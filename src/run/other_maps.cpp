#include "run/other_maps.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "merging/map_joining.hpp"
#include "merging/map_merging.hpp"
#include "slam/local_map.hpp"

namespace matchbox_slam {
namespace {

/// Ends work whose result nobody wants any more.
struct GivenUp {};

bool is_same_scan(const KeyScan& a, const KeyScan& b) {
  if (a.stamp() != b.stamp()) {
    return false;
  }
  const std::optional<MeasuredScan> one = a.measured();
  const std::optional<MeasuredScan> other = b.measured();
  const auto is_same_range = [](float range, float other_range) {
    return range == other_range || (std::isnan(range) && std::isnan(other_range));
  };
  return one && other &&
         std::equal(one->scan.ranges.begin(), one->scan.ranges.end(), other->scan.ranges.begin(),
                    other->scan.ranges.end(), is_same_range);
}

/// Of a map, how many key scans another one has, too.
std::size_t count_shared(const KeyScans& keys, const KeyScans& others) {
  std::map<double, const KeyScan*> by_stamp;
  for (const PlacedScan& other : others.all()) {
    by_stamp.emplace(other.scan->stamp(), other.scan.get());
  }
  return static_cast<std::size_t>(
      std::count_if(keys.all().begin(), keys.all().end(), [&](const PlacedScan& key) {
        const auto other = by_stamp.find(key.scan->stamp());
        return other != by_stamp.end() && is_same_scan(*key.scan, *other->second);
      }));
}

/// The run's map as one of those that are joined; not drawn.
MergedMap merged_map_of(const OwnMap& own) {
  return {{SlamMap(own.options.map, own.options.field), own.key_scans, {}, 0.0}, own.loops, {}, {}};
}

/// What tells key scans of a run apart however it went on: stamps may step back, and numbers and
/// order change where some make room or were waiting. Stamp [s], laser, and how many there are of
/// both before.
using ScanName = std::tuple<double, int, std::size_t>;

/// Of each, in their order.
std::vector<ScanName> names_of(const PlacedScans& keys) {
  std::map<std::pair<double, int>, std::size_t> count;
  std::vector<ScanName> names;
  names.reserve(keys.size());
  for (const PlacedScan& key : keys) {
    const std::pair<double, int> seen{key.scan->stamp(), key.scan->laser()};
    names.emplace_back(seen.first, seen.second, count[seen]++);
  }
  return names;
}

/// As they are drawn, in a box along the axes.
double spanned_cells(const PlacedScans& keys, double resolution) {
  Eigen::AlignedBox2d box;
  for (const PlacedScan& key : keys) {
    const std::shared_ptr<const PointScan> points = key.scan->points();
    for (const ScanPoint& point : points->points) {
      box.extend(key.map_from_base * point.origin);
      box.extend(key.map_from_base * point.position);
    }
    for (const FreeRay& ray : points->free_rays) {
      box.extend(key.map_from_base * ray.origin);
      box.extend(key.map_from_base * ray.end);
    }
  }
  return box.isEmpty() ? 0.0 : box.volume() / (resolution * resolution);
}

void require_room(const PlacedScans& keys, const MapOptions& options) {
  const double cells = spanned_cells(keys, options.resolution);
  if (cells > options.max_cells) {
    throw std::runtime_error(
        fmt::format("with it this map would span {} cells, and map/max_cells allows {}; raise "
                    "map/max_cells, or make both maps with a larger map/resolution",
                    to_string(std::ceil(cells)), to_string(options.max_cells)));
  }
}

std::size_t nearest_to(const Eigen::Vector2d& here, const PlacedScans& keys) {
  const auto nearest =
      std::min_element(keys.begin(), keys.end(), [&](const PlacedScan& a, const PlacedScan& b) {
        return distance(a, here) < distance(b, here);
      });
  return static_cast<std::size_t>(nearest - keys.begin());
}

}  // namespace

/// A map, or one of its disconnected components.
struct OtherMaps::Searched {
  std::string name;
  MergedMap map;
  std::unique_ptr<MeetingWalk> walk;
  std::map<ScanName, Pose2> walked = {};  ///< walked_from_base of each key scan that was
  Pose2 walked_from_own = {};
  ScanName met = {};  ///< the one that was found
  Pose2 other_from_met = {};
  std::shared_ptr<const FoundMap> found = nullptr;
  MergedJoint joint = {};  ///< of both, when it is found
  bool is_taken = false;
};

OtherMaps::OtherMaps(Look look, Give give, RunDialog dialog)
    : look_(std::move(look)), give_(std::move(give)), dialog_(std::move(dialog)) {}

void OtherMaps::give_up() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
}

OtherMaps::~OtherMaps() {
  give_up();
  if (thread_.joinable()) {
    thread_.join();
  }
}

void OtherMaps::add(const std::string& name, EngineState map) {
  const OwnMap own = look_();
  const std::string twice = "; a map is given once, and not to the robot that made it";
  if (const std::size_t shared = count_shared(map.key_scans, own.key_scans); shared > 0) {
    throw std::runtime_error(fmt::format("{}: {} of its {} key scans are in this map already{}",
                                         name, shared, map.key_scans.size(), twice));
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const Given& given : given_) {
    if (count_shared(map.key_scans, given.key_scans) > 0) {
      throw std::runtime_error(
          fmt::format("{}: is searched already, as {}{}", name, given.name, twice));
    }
  }
  KeyScans key_scans = map.key_scans;
  given_.push_back(
      {name, std::move(key_scans), std::make_shared<const EngineState>(std::move(map))});
  if (!thread_.joinable()) {
    thread_ = std::thread([this] { run(); });
  }
  changed_.notify_all();
}

void OtherMaps::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  given_.clear();
  begun_ = 0;
  ++generation_;
}

void OtherMaps::require_going_on() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (stop_ || generation_ != searched_generation_) {
    throw GivenUp{};
  }
}

void OtherMaps::run() {
  constexpr std::chrono::milliseconds kSearchInterval(200);  // a key scan comes about as often
  for (;;) {
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait_for(lock, kSearchInterval, [this] { return stop_; });
      if (stop_) {
        return;
      }
      if (generation_ != searched_generation_) {
        searched_.clear();
        waiting_ = 0;
        searched_generation_ = generation_;
      }
    }
    try {
      take_added();
      std::for_each(searched_.begin(), searched_.end(),
                    [this](Searched& one) { search_or_tell(one); });
    } catch (const GivenUp&) {
      continue;
    } catch (const std::exception& error) {
      dialog_.warn(std::string("other robots' maps: ") + error.what());
    }
    searched_.erase(std::remove_if(searched_.begin(), searched_.end(),
                                   [](const Searched& one) { return one.is_taken; }),
                    searched_.end());
    waiting_ = searched_.size();
  }
}

/// Draws those that are new.
void OtherMaps::take_added() {
  for (;;) {
    Given given;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (generation_ != searched_generation_ || begun_ == given_.size()) {
        return;
      }
      given.name = given_[begun_].name;
      given.map = std::move(given_[begun_++].map);
    }
    const EngineOptions options = look_().options;
    for (MergedMap& map : maps_of(*given.map, options)) {
      require_going_on();
      auto walk = std::make_unique<MeetingWalk>(map.component, options);
      searched_.push_back({given.name, std::move(map), std::move(walk)});
    }
  }
}

/// One that cannot be searched does not stop the others.
void OtherMaps::search_or_tell(Searched& searched) {
  try {
    search(searched);
  } catch (const GivenUp&) {
    throw;
  } catch (const std::exception& error) {
    dialog_.warn(fmt::format("{}: is searched no more: {}", searched.name, error.what()));
    searched.is_taken = true;
  }
}

void OtherMaps::search(Searched& searched) {
  const OwnMap own = look_();
  if (searched.found == nullptr) {
    walk(searched, own);
    return;
  }
  switch (searched.found->fate) {
    case FoundMap::Fate::kWaiting:
      give_(searched.found);  // a run that goes on with a saved map may have begun since
      break;
    case FoundMap::Fate::kTaken:
      searched.is_taken = true;
      dialog_.inform(fmt::format(
          "{}: meets this map; {} key scans of it are part of this one now, joined by {} matches "
          "and {} loops",
          searched.name, searched.map.component.key_scans.size(), searched.joint.matched,
          searched.joint.closed));
      break;
    case FoundMap::Fate::kOutdated:
      if (!join(searched, own)) {
        searched.found = nullptr;
      }
      break;
  }
}

/// On along what has come since, from what lies before it: the map may have moved.
void OtherMaps::walk(Searched& searched, const OwnMap& own) {
  const PlacedScans& keys = own.key_scans.all();
  const std::vector<ScanName> names = names_of(keys);
  for (std::size_t i = 0; i < keys.size() && searched.found == nullptr; ++i) {
    const auto before = searched.walked.find(names[i]);
    if (before != searched.walked.end()) {
      searched.walked_from_own = before->second * keys[i].map_from_base.inverse();
      continue;
    }
    require_going_on();
    const Pose2 walked_from_base = searched.walked_from_own * keys[i].map_from_base;
    searched.walked.emplace(names[i], walked_from_base);
    const std::optional<Pose2> other_from_walked =
        searched.walk->go_on_to({keys[i].scan, walked_from_base});
    if (other_from_walked) {
      searched.met = names[i];
      searched.other_from_met = *other_from_walked * walked_from_base;
      if (!join(searched, own)) {
        searched.walk->disbelieve(*other_from_walked);
      }
    }
  }
}

/// As both are now. Whether what they saw does not contradict that.
bool OtherMaps::join(Searched& searched, const OwnMap& own) {
  const PlacedScans& keys = own.key_scans.all();
  const std::vector<ScanName> names = names_of(keys);
  const auto name = std::find(names.begin(), names.end(), searched.met);
  if (name == names.end()) {
    return false;
  }
  const PlacedScan& met = keys[static_cast<std::size_t>(name - names.begin())];
  const Pose2& other_from_base = searched.other_from_met;
  const MapMeeting meeting{
      nearest_to(other_from_base.translation(), searched.map.component.key_scans.all()),
      met.map_from_base * other_from_base.inverse()};
  std::optional<MergedMap> both = joined(searched.map, merged_map_of(own), meeting, own.options,
                                         [this] { require_going_on(); });
  if (!both) {
    return false;
  }
  require_room(both->component.key_scans.all(), own.options.map);
  searched.joint = both->joints.back();
  searched.found = std::make_shared<const FoundMap>(
      keys, own.loops, std::move(both->component.key_scans), std::move(both->loops));
  give_(searched.found);
  return true;
}

}  // namespace matchbox_slam
