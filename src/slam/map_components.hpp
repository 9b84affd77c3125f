#pragma once

#include <cstddef>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/map_component.hpp"

namespace matchbox_slam {

/// The map, the components that a lost robot made besides, which of them the robot is in, and scans
/// that wait to be inserted: components by number, the map 0. A value.
class MapComponents {
 public:
  /// @param components  the map first.
  explicit MapComponents(std::vector<MapComponent> components, std::size_t active = 0,
                         std::vector<WaitingScan> waiting = {});

  [[nodiscard]] const std::vector<MapComponent>& all() const { return components_; }
  [[nodiscard]] const std::vector<WaitingScan>& waiting() const { return waiting_; }
  /// Number of the component that the robot is in.
  [[nodiscard]] std::size_t active_number() const { return active_; }
  [[nodiscard]] bool is_lost() const { return active_ > 0; }
  /// Whether the component of a lost robot holds hardly anything.
  [[nodiscard]] bool has_just_begun() const;

  [[nodiscard]] MapComponent& map() { return components_.front(); }
  [[nodiscard]] const MapComponent& map() const { return components_.front(); }
  [[nodiscard]] MapComponent& active() { return components_[active_]; }
  [[nodiscard]] const MapComponent& active() const { return components_[active_]; }

  /// The robot is lost: from now on it is in a component of its own, the one that it is in already
  /// where that holds hardly anything. Returns whether another component had to be given up for it.
  /// @param empty  the component, with the stamp that it begins at.
  [[nodiscard]] bool begin_component(MapComponent empty);

  /// The robot is found: the component that it is in becomes one with another.
  /// @param with_key_scans  its key scans wait to be inserted there.
  void join(std::size_t component, const Pose2& component_from_active, bool with_key_scans);

  /// The robot is in the map, whatever was thought before; nothing waits any more.
  void go_to_map();

  /// The oldest scan that waits for the component that the robot is in.
  [[nodiscard]] const WaitingScan* next_waiting() const;
  /// Takes it out.
  void drop_next_waiting();

  /// The map's frame has moved where the robot is.
  void move_waiting_for_map(const Pose2& new_from_old);

 private:
  void forget_waiting_for(std::size_t component);
  void give_up_smallest();
  void remove(std::size_t component, std::size_t heir, const Pose2& heir_from_component);
  void leave_if_found();

  std::vector<MapComponent> components_;
  std::size_t active_;
  std::vector<WaitingScan> waiting_;
};

}  // namespace matchbox_slam
