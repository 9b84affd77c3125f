#pragma once

#include <cstddef>
#include <future>
#include <memory>
#include <utility>
#include <vector>

#include "matchbox_slam/slam/engine_options.hpp"
#include "slam/local_map.hpp"
#include "slam/loop_closing.hpp"
#include "slam/map_components.hpp"

namespace matchbox_slam {

/// How much of a map is drawn, and what scans are matched against in it: the whole map while all
/// its key scans lie well to each other, else a map of those near the robot that do. Then the whole
/// one is drawn when somebody asks for it. A value; the map itself is its MapComponent's.
class MapRenderer {
 public:
  MapRenderer() = default;
  /// @param local_map  empty: the whole map is matched against.
  /// @param is_moved  by loops, and matched against the local map alone since.
  /// @param drawn     key scans that the whole map shows.
  MapRenderer(LocalMap local_map, bool is_moved, std::size_t drawn)
      : local_map_(std::move(local_map)), is_moved_(is_moved), drawn_(drawn) {}

  [[nodiscard]] const LocalMap& local_map() const { return local_map_; }
  [[nodiscard]] bool is_moved() const { return is_moved_; }
  /// Whether the whole map is to be rendered anew, not only to be added to.
  [[nodiscard]] bool is_outdated() const { return is_outdated_; }

  [[nodiscard]] const SlamMap& matched(const MapComponent& component) const {
    return local_map_.map() != nullptr ? *local_map_.map() : component.map;
  }

  /// Draws what the whole map lacks, or waits until it is drawn, to be looked at: its field is not
  /// rendered where only the local map is matched against.
  const SlamMap& drawn(MapComponent& component, const EngineOptions& options);

  /// The same with its field.
  const SlamMap& whole(MapComponent& component, const EngineOptions& options);

  /// Takes a whole map that was `rendered` from key scans as they were. Left alone where they have
  /// moved since.
  void take_rendered(SlamMap map, const PlacedScans& keys, MapComponent& component);

  /// Adds a key scan, and draws it where the whole map is matched against; else `catch_up` does.
  /// @param points  of it.
  void add(const PlacedScan& key, const PointScan& points, MapComponent& component,
           const EngineOptions& options);

  /// Lets a map of what lies near take effect.
  void match_locally(LocalMap local_map) { local_map_ = std::move(local_map); }
  /// From now on.
  void match_whole(MapComponent& component, const EngineOptions& options);
  /// The same where nobody asks for the map for a while: what it lacks is drawn beside. Whether
  /// that may take long, which does not depend on who has asked for the whole map before.
  bool begin_whole(const MapComponent& component, const EngineOptions& options);

  /// The whole map shows what it should not.
  void expect_redrawing() { is_outdated_ = true; }

  /// The key scans move: what was drawn is outdated.
  void expect_move() { is_moved_ = is_outdated_ = true; }

  /// What lies near is matched against from the next such map on, though nothing has moved.
  void expect_local_map() { is_moved_ = true; }

  /// Some key scans are no more: what was drawn is outdated. Those that what lies near shows stay.
  /// See LocalMap.
  void renumber(const std::vector<std::size_t>& numbers, std::size_t gone) {
    local_map_.renumber(numbers, gone);
    expect_move();
  }

  /// Draws the key scans that what lies near has not taken in.
  void catch_up(const MapComponent& component, const EngineOptions& options) {
    local_map_.take_new(component.key_scans.all(), options.map);
  }

 private:
  /// A map that another thread renders.
  struct Rendering {
    PlacedScans keys;
    std::future<SlamMap> map;
  };

  LocalMap local_map_;
  bool is_moved_ = false;
  bool is_outdated_ = false;
  std::size_t drawn_ = 0;                 ///< key scans that the whole map shows
  std::shared_ptr<Rendering> rendering_;  ///< null: none
};

}  // namespace matchbox_slam
