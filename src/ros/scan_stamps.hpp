#pragma once

#include <ros/time.h>

#include <optional>
#include <vector>

namespace matchbox_slam {

/// [s] Less than this is a message out of order, more is a clock that was set back.
constexpr double kTimeJump = 1.0;

/// [s] that a scan waits for those of other lasers, and the first of a laser for the next, which
/// tells whether it is a part of a turn; a laser that is silent for as long is off.
constexpr double kPatienceWithLasers = 0.5;  // of lasers from 4 Hz on two scans or more

/// What the stamps of scans tell of clocks, and of which scan is the next.
class ScanStamps {
 public:
  explicit ScanStamps(int lasers) : lasers_(static_cast<std::size_t>(lasers)) {}

  /// Whether the stamp is of before the latest time jump. No such scan may come among what follows,
  /// which would seem older than it.
  [[nodiscard]] bool is_straggler(const ros::Time& stamp, const ros::Time& now) const;

  /// Whether with this scan it is certain that the clock of its laser was set back. One whose scans
  /// are older than another's alone is late.
  /// @param used  the latest scan that was; null: none.
  [[nodiscard]] bool is_set_back(const ros::Time& stamp, int laser, const ros::Time* used);

  /// Whether the stamp is wrong, by how far it is ahead of the scan's arrival: some in a row are of
  /// another clock.
  [[nodiscard]] bool leaps_ahead(const ros::Time& stamp, const ros::Time& now);

  /// The laser has sent a scan, and will send none that is earlier.
  void note(const ros::Time& stamp, int laser);

  /// Whether no laser that is alive is likely to send an earlier scan. One not heard of yet is
  /// waited for as well.
  [[nodiscard]] bool is_next(const ros::Time& stamp) const;

  /// Time has jumped back by so many seconds.
  void jump_back(double seconds, const ros::Time& now);

 private:
  struct Laser {
    std::optional<ros::Time> newest;
    ros::Time last_old;    ///< of those older than time can be
    int old_in_a_row = 0;  ///< each later than the one before
  };
  /// Which scans come from before the latest time jump, and how long such ones may come.
  struct Straggling {
    double least_stamp = 0.0;   ///< [s]
    double last_arrival = 0.0;  ///< [s]
  };

  std::size_t lasers_;
  std::optional<ros::Time> first_;  ///< since time jumped back
  std::vector<Laser> by_laser_ = std::vector<Laser>(lasers_);
  std::optional<Straggling> straggling_;
  std::optional<double> lead_;  ///< [s] of the newest scan's stamp before its arrival
  int leaps_in_a_row_ = 0;
};

}  // namespace matchbox_slam
