#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/sensor/laser_scan.hpp"

namespace matchbox_slam {

/// Makes whole turns of the parts that some lasers send one after the other. A part begins where
/// the one before has ended, in angle and in time. The whole is a scan as a laser would have sent
/// it that does not divide its turns: beams of parts that are missing are NaN, and its beams are
/// placed by odometry over all of its time. Several parts share one odometry so; over the 0.1 s of
/// a turn that is what whole scans have, too.
class ScanJoiner {
 public:
  /// @param parts  of a turn; none: as many as are seen to be.
  explicit ScanJoiner(std::optional<int> parts) : parts_(parts) {}

  /// Scans of one laser in the order of their stamps. Those that are whole now are taken by `take`.
  /// With 'auto' the first one is whole until the second goes on where it has ended, or the third
  /// where the second did, if that comes after a gap. Returns whether that is now: the one before
  /// comes again with its turn, and is not to be used alone.
  [[nodiscard]] bool add(LaserScan scan);

  /// Whether the newest scan, which is whole so far, may be a part.
  [[nodiscard]] bool is_undecided() const { return first_.has_value(); }

  /// The parts that wait for the rest of their turn are whole.
  void finish();

  /// Forgets all scans, and whether parts come.
  void begin_anew();

  /// Whole scans, oldest first; they are the caller's.
  [[nodiscard]] std::vector<LaserScan> take();

  /// Whether parts wait for the rest.
  [[nodiscard]] bool holds_parts() const { return joined_ > 0; }
  /// What is done about parts, when it is decided, for people; empty: nothing.
  [[nodiscard]] std::string take_news();

 private:
  [[nodiscard]] std::optional<std::size_t> place_after(const LaserScan& whole,
                                                       const LaserScan& part) const;
  void begin(LaserScan&& part);
  void append(const LaserScan& part, std::size_t first_beam);
  void note_alone();
  void watch(const LaserScan& scan);
  [[nodiscard]] bool is_whole() const;

  std::optional<int> parts_;
  bool is_watching_ = true;  ///< with 'auto': it is not known yet whether parts come
  bool joins_ = false;
  bool has_waited_ = false;  ///< through a gap, for one that tells
  std::optional<LaserScan> first_;
  LaserScan whole_;
  int joined_ = 0;  ///< parts of `whole_`
  int alone_ = 0;   ///< turns in a row of one part, where there should be more
  std::vector<LaserScan> ready_;
  std::string news_;
};

}  // namespace matchbox_slam
