#include "slam/map_components.hpp"

#include <algorithm>
#include <utility>

namespace matchbox_slam {

MapComponents::MapComponents(std::vector<MapComponent> components, std::size_t active,
                             std::vector<WaitingScan> waiting)
    : components_(std::move(components)), active_(active), waiting_(std::move(waiting)) {}

bool MapComponents::has_just_begun() const {
  constexpr std::size_t kMinKeyScans = 3;  // key scans; a guess: half and double were not tried
  return is_lost() && active().key_scans.size() < kMinKeyScans;
}

bool MapComponents::begin_component(MapComponent empty) {
  if (has_just_begun()) {
    empty.begin = active().begin;
    empty.parent = active().parent;
    empty.parent_from_component = active().parent_from_component;
    active() = std::move(empty);
    forget_waiting_for(active_);
  } else {
    empty.parent = active_;
    components_.push_back(std::move(empty));
    active_ = components_.size() - 1;
  }
  const bool are_too_many = components_.size() - 1 > kMostDisconnectedComponents;
  if (are_too_many) {
    give_up_smallest();
  }
  return are_too_many;
}

void MapComponents::forget_waiting_for(std::size_t component) {
  const auto waits = [&](const WaitingScan& scan) { return scan.component == component; };
  waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(), waits), waiting_.end());
}

/// Of those besides the map that the robot is not in, with what waits for it.
void MapComponents::give_up_smallest() {
  const auto smallest = std::min_element(
      components_.begin() + 1, components_.end() - 1,
      [](const auto& a, const auto& b) { return a.key_scans.size() < b.key_scans.size(); });
  const auto component = static_cast<std::size_t>(smallest - components_.begin());
  forget_waiting_for(component);
  const Pose2 parent_from_component = smallest->parent_from_component;
  remove(component, smallest->parent, parent_from_component);
  active_ = components_.size() - 1;
}

void MapComponents::join(std::size_t component, const Pose2& component_from_active,
                         bool with_key_scans) {
  const std::size_t joined = active_;
  const double begin = active().begin;
  for (WaitingScan& waiting : waiting_) {
    if (waiting.component == joined) {
      waiting = {component,
                 {waiting.scan.scan, component_from_active * waiting.scan.map_from_base}};
    }
  }
  if (with_key_scans) {
    for (const PlacedScan& key : active().key_scans.all()) {
      waiting_.push_back({component, {key.scan, component_from_active * key.map_from_base}});
    }
  }
  remove(joined, component, component_from_active);
  active_ = component > joined ? component - 1 : component;
  active().begin = std::min(active().begin, begin);
  active().last_inserted.clear();
  leave_if_found();
}

/// Takes a component out that nothing waits for. What followed it follows the one whose frame is
/// given from now on, and the numbers of the components behind are lower by one.
void MapComponents::remove(std::size_t component, std::size_t heir,
                           const Pose2& heir_from_component) {
  for (std::size_t i = 0; i < components_.size(); ++i) {
    MapComponent& other = components_[i];
    if (other.parent == component) {
      other.parent = heir == component ? i : heir;
      other.parent_from_component = heir_from_component * other.parent_from_component;
    }
    other.parent -= other.parent > component ? 1 : 0;
  }
  for (WaitingScan& waiting : waiting_) {
    waiting.component -= waiting.component > component ? 1 : 0;
  }
  components_.erase(components_.begin() + static_cast<std::ptrdiff_t>(component));
}

/// Poses that were taken in components that the robot is not in any more are not to be put right
/// later: others have come after them.
void MapComponents::leave_if_found() {
  constexpr double kNever = 1e15;  // [s]
  if (!is_lost()) {
    std::for_each(components_.begin() + 1, components_.end(),
                  [](MapComponent& component) { component.begin = kNever; });
  }
}

void MapComponents::go_to_map() {
  active_ = 0;
  leave_if_found();
  waiting_.clear();
}

const WaitingScan* MapComponents::next_waiting() const {
  const auto next = std::find_if(waiting_.begin(), waiting_.end(), [this](const WaitingScan& scan) {
    return scan.component == active_;
  });
  return next == waiting_.end() ? nullptr : &*next;
}

void MapComponents::drop_next_waiting() {
  if (const WaitingScan* next = next_waiting()) {
    waiting_.erase(waiting_.begin() + (next - waiting_.data()));
  }
}

void MapComponents::move_waiting_for_map(const Pose2& new_from_old) {
  for (WaitingScan& waiting : waiting_) {
    if (waiting.component == 0) {
      waiting.scan.map_from_base = new_from_old * waiting.scan.map_from_base;
    }
  }
}

}  // namespace matchbox_slam
