#pragma once

#include <cstddef>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/map_part.hpp"

namespace matchbox_slam {

/// The map, what a lost robot made apart from it, the part that the robot is in, and scans that
/// wait to be inserted: parts by number, the map 0. A value.
class MapParts {
 public:
  /// @param parts  the map first.
  explicit MapParts(std::vector<MapPart> parts, std::size_t here = 0,
                    std::vector<WaitingScan> waiting = {});

  [[nodiscard]] const std::vector<MapPart>& all() const { return parts_; }
  [[nodiscard]] const std::vector<WaitingScan>& waiting() const { return waiting_; }
  [[nodiscard]] std::size_t here_number() const { return here_; }
  [[nodiscard]] bool is_lost() const { return here_ > 0; }

  [[nodiscard]] MapPart& map() { return parts_.front(); }
  [[nodiscard]] const MapPart& map() const { return parts_.front(); }
  [[nodiscard]] MapPart& here() { return parts_[here_]; }
  [[nodiscard]] const MapPart& here() const { return parts_[here_]; }

  /// The robot is lost: from now on it is in a part of its own, the one that it is in already where
  /// that holds hardly anything. Returns whether another part had to be given up for it.
  /// @param empty  the part, with the stamp that it begins at.
  [[nodiscard]] bool begin_apart(MapPart empty);

  /// The robot is found: the part that it is in becomes one with another.
  /// @param with_key_scans  its key scans wait to be inserted there.
  void join(std::size_t part, const Pose2& part_from_here, bool with_key_scans);

  /// The robot is in the map, whatever was thought before; nothing waits any more.
  void go_to_map();

  void wait(const std::vector<WaitingScan>& scans) {
    waiting_.insert(waiting_.end(), scans.begin(), scans.end());
  }
  /// The oldest scan that waits for the part that the robot is in.
  [[nodiscard]] const WaitingScan* next_waiting() const;
  /// Takes it out.
  void drop_next_waiting();

  /// The map's frame has moved where the robot is.
  void move_waiting_for_map(const Pose2& new_from_old);

 private:
  void give_up_smallest();
  void remove(std::size_t part, std::size_t heir, const Pose2& heir_from_part);
  void leave_if_found();

  std::vector<MapPart> parts_;
  std::size_t here_;
  std::vector<WaitingScan> waiting_;
};

}  // namespace matchbox_slam
