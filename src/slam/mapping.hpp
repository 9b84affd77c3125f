#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "slam/loop_closing.hpp"
#include "slam/map_components.hpp"
#include "slam/map_renderer.hpp"
#include "slam/temporary_map.hpp"

namespace matchbox_slam {

struct FoundMap;

/// How well it is known where a scan was taken that has waited to be inserted, over (x, y, theta).
[[nodiscard]] Eigen::Matrix3d covariance_of_waiting();

/// What scans are mapped into: the components of the map, their key scans, and for the map the
/// graph of its key scans and how much of it is drawn. Takes scans in, and moves what it took when
/// a loop is closed. Where the robot is, it is told.
class Mapping {
 public:
  /// An empty map.
  explicit Mapping(const EngineOptions& options);
  /// Goes on; for the last two see EngineState.
  Mapping(MapComponents components, LoopCloser loops, MapRenderer drawing, bool is_continued,
          bool is_of_key_scans, const EngineOptions& options);

  [[nodiscard]] const EngineOptions& options() const { return options_; }
  [[nodiscard]] const MapComponents& components() const { return components_; }
  [[nodiscard]] const LoopCloser& loops() const { return loops_; }
  [[nodiscard]] const MapRenderer& renderer() const { return renderer_; }
  [[nodiscard]] bool is_continued() const { return is_continued_; }
  [[nodiscard]] bool is_of_key_scans() const { return is_of_key_scans_; }

  [[nodiscard]] bool is_lost() const { return components_.is_lost(); }
  [[nodiscard]] bool closes_loops() const { return options_.slam.loop_closing && is_of_key_scans_; }
  /// Whether something waits that may be inserted into the component that the robot is in.
  [[nodiscard]] bool has_pending() const;

  /// What scans are matched against.
  [[nodiscard]] const SlamMap& matched() const;
  /// The same of a robot that is not lost, without what is drawn over it.
  [[nodiscard]] const SlamMap& lasting() const { return renderer_.matched(components_.map()); }
  [[nodiscard]] const TemporaryMap& temporary() const { return temporary_; }
  /// The map, drawn as far as it goes. See MapRenderer.
  const SlamMap& drawn() { return renderer_.drawn(components_.map(), options_); }
  /// The same with its field.
  const SlamMap& whole() { return renderer_.whole(components_.map(), options_); }
  /// See MapRenderer.
  void take_rendered(SlamMap map, const PlacedScans& keys);

  // --- scans ---

  /// Makes a scan a key scan of the component that the robot is in; `catch_up` is to follow. False
  /// when the map has no room for it.
  /// @param points      of it.
  /// @param covariance  of its pose, in the map frame.
  bool insert(const PointScan& points, const PlacedScan& placed, const Eigen::Matrix3d& covariance);
  /// Draws a scan over the map, which stays as it is; not where the map has no room for it.
  void draw_over(const PointScan& points, int laser, const Pose2& map_from_base);
  /// The robot is elsewhere than where the newest key scan and the motion since say.
  void break_off() { is_continued_ = false; }
  /// Draws the key scans that have come since, where only what lies near is matched against. To be
  /// called before the next scan is matched or the map is saved, and after `close_loops`, which may
  /// replace or drop what would be drawn into.
  void catch_up() { renderer_.catch_up(components_.map(), options_); }
  /// Inserts a few of those that wait, where the map holds them. Returns how many it has no room
  /// for.
  std::size_t insert_pending();

  // --- where the robot may be elsewhere ---

  /// From now on what is inserted may have been seen elsewhere.
  void fork();
  /// It was not.
  void unfork() { fork_.reset(); }
  /// What scans are compared in: what was matched against before the fork, if there is one.
  [[nodiscard]] const SlamMap& compared() const;
  /// What was inserted since the fork was seen elsewhere. Returns how it has moved.
  /// @param poses         of the key scans since; none: where it is.
  /// @param new_from_old  of the newest scan, whose stamp [s] is given.
  MapCorrection move_since_fork(const std::vector<std::optional<Pose2>>& poses,
                                const Pose2& new_from_old, double stamp);
  /// What was inserted since the fork was seen nobody knows where: the fork is now.
  void forget_since_fork();
  /// By laser where it was inserted last before the fork, if there is one.
  [[nodiscard]] std::map<int, Pose2> inserted_before_fork() const {
    return fork_ ? fork_->last_inserted : std::map<int, Pose2>{};
  }
  /// Makes a fork again.
  /// @param key_scans  that the component had then.
  void fork_as_of(std::size_t key_scans, std::map<int, Pose2> last_inserted);

  // --- loops, in the map ---

  /// With the newest key scan: lets a search that is due take effect, and begins the next. Returns
  /// how the map has moved, if it has.
  std::optional<MapCorrection> close_loops();
  /// Waits for a search that is under way, and lets it take effect; `catch_up` is to follow.
  std::optional<MapCorrection> finish_loops();

  /// Another robot's map comes in with one of the next key scans, when no search is under way; its
  /// fate tells.
  void expect_map(std::shared_ptr<const FoundMap> found) { found_ = std::move(found); }

  /// A search that is under way is abandoned, what was drawn over the map is forgotten, and where
  /// nothing is to move the map the whole of it is matched against.
  void set_options(const EngineOptions& options);

  // --- where the robot is ---

  /// In the map, elsewhere than was thought.
  void go_to_map();

  struct BegunComponent {
    bool gave_up_component = false;  ///< see MapComponents::begin_component
    /// The whole map is drawn by another thread, which takes a while.
    bool is_drawn_beside = false;
  };
  /// Lost, since the scan of this stamp [s].
  BegunComponent begin_component(double stamp);
  /// Found in that component.
  void join(std::size_t component, const Pose2& component_from_active);

 private:
  bool add(const PointScan& points, const PlacedScan& placed, const Eigen::Matrix3d& covariance,
           bool is_continued);
  void match_whole_map() { renderer_.match_whole(components_.map(), options_); }
  void match_as();
  /// The key scans have moved, and what goes with the newest follows.
  void move_with_map(const Pose2& new_from_old);
  /// Those around the newest.
  [[nodiscard]] LocalScans scans_around() const;
  void take_out(const std::vector<std::uint64_t>& ids);
  std::optional<MapCorrection> take_found_map();

  /// What it takes to go back to before the robot may have been elsewhere.
  struct Fork {
    std::size_t key_scans;
    std::map<int, Pose2> last_inserted;
    SlamMap map;  ///< of the component that the robot is in
    MapRenderer drawing;
  };

  void draw_since(std::size_t key_scan);

  EngineOptions options_;
  MapComponents components_;
  LoopCloser loops_;
  MapRenderer renderer_;
  TemporaryMap temporary_;  ///< while the map is not to change
  std::optional<Fork> fork_;
  std::shared_ptr<const FoundMap> found_;  ///< null: none is expected
  bool is_continued_ = false;              ///< see EngineState
  bool is_of_key_scans_ = true;            ///< see EngineState
};

}  // namespace matchbox_slam
