#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/duration.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "matchbox_slam/slam/slam_engine.hpp"
#include "odometry/sweep_times.hpp"
#include "ros/robot_transforms.hpp"
#include "ros/scan_account.hpp"
#include "ros/scan_message.hpp"
#include "ros/scan_stamps.hpp"
#include "run/run_event.hpp"
#include "sensor/scan_joiner.hpp"
#include "sensor/scan_timing.hpp"

namespace matchbox_slam {

/// A scan with all that the engine needs.
struct ReadyScan {
  ros::Time stamp;    ///< of the first beam, by the clock of tf
  ros::Time arrival;  ///< by the clock of messages; later of a scan that was kept back
  std::string frame;
  ScanInput input;
  bool is_odometry_in_tf = true;  ///< where it has odometry
};

/// Time went back, as when a clock is set, a bag is played in a loop or a simulation is reset.
/// Stamps from here on cannot be compared with those before.
struct TimeJump {
  double seconds = 0.0;  ///< how far back, > 0
  bool stopped = false;  ///< no more scans are delivered
};

/// What to say of a time jump that comes after so many scans, up to what is done about it.
[[nodiscard]] std::string text_of(const TimeJump& jump, std::size_t scans_before);

/// A scan that was ready is skipped, as there is no time for it.
struct LeftOut {
  double stamp = 0.0;  ///< [s] of the first beam, by the clock of tf
  int laser = 0;
};

struct ScanQueueSettings : RobotFrames {
  double transform_timeout = 2.0;   ///< [s] that a scan may wait for its transforms
  std::size_t max_waiting = 10000;  ///< scans
  ros::Duration scan_time_offset;   ///< added to the stamps of scans
  bool stop_at_time_jump = false;   ///< else start anew
  int lasers = 1;                   ///< whose scans are merged
  double max_lag = 0.0;             ///< [s] after its arrival a scan is given up; 0: never
  ProjectionOptions projection;     ///< max_tilt, and that of scans that tell how the robot moves
  ScanTiming timing;
  /// [s] by laser, where their sweeps are to be found out: whoever has looked at the recording
  /// before knows them.
  std::map<int, double> shown_sweeps;
};

/// Scans and transforms go in as they arrive, scans ready to be processed come out in the order of
/// their stamps, and events between them; in the place of one that there was no time for, that. A
/// scan is ready when its transforms cover its first beam and its last (RobotTransforms); they are
/// looked up at that moment. What comes out depends on the messages and not on how scans and
/// transforms interleave, so a replayed bag gives what reading it gives, but for sweeps that
/// whoever reads it has seen before. No scan is lost uncounted.
///
/// The first scan of a laser waits for the next one, but not for long, since that tells whether
/// they are parts of a turn.
///
/// Scans of several lasers come out merged by their stamps: a scan waits until every other laser
/// that is alive has sent one as late, but not for long.
///
/// "Now" is the clock by which messages arrive: the time at which a bag recorded them, or the
/// node's ros::Time.
class ScanQueue {
 public:
  using Item = std::variant<ReadyScan, TimeJump, RunEvent, LeftOut>;

  explicit ScanQueue(ScanQueueSettings settings);

  /// @param laser  which one of the robot's, from 0.
  void add_scan(const sensor_msgs::LaserScan& message, const ros::Time& now, int laser = 0);
  /// The same of any message; one with a defect is counted as skipped.
  void add_scan(const ScanMessage& message, const ros::Time& now, int laser = 0);
  void add_transforms(const tf2_msgs::TFMessage& message, bool is_static, const ros::Time& now);

  /// As of RobotTransforms: scans wait for these as for tf.
  [[nodiscard]] std::string add_imu(const sensor_msgs::Imu& message, const ros::Time& now);

  [[nodiscard]] std::string add_odometry(const nav_msgs::Odometry& message, const ros::Time& now);
  [[nodiscard]] std::size_t invalid_odometry() const { return transforms_.invalid_odometry(); }

  /// The event comes out after all that is ready now; scans that still wait for their transforms
  /// come after it, since nobody knows for how long. Where it gives up the map, scans that are
  /// ready are skipped, so that it comes next.
  void add_event(RunEvent event);

  /// The next scan, when it is ready, or event. None: wait for more messages.
  [[nodiscard]] std::optional<Item> next();

  /// What `next` will give; null: nothing.
  [[nodiscard]] const Item* peek() const { return ready_.empty() ? nullptr : &ready_.front(); }

  /// Added to the stamps of scans that come from now on.
  void set_scan_time_offset(const ros::Duration& offset) { settings_.scan_time_offset = offset; }
  /// These of the settings, from now on.
  void set_limits(double max_lag, double max_tilt) {
    settings_.max_lag = max_lag;
    settings_.projection.max_tilt = max_tilt;
  }

  /// Whether scans are skipped since a time jump at which to stop.
  [[nodiscard]] bool stopped() const { return stopped_; }

  /// Takes scans again after such a time jump.
  void start_again() { stopped_ = false; }

  /// Counts what was delivered so far as skipped: its map is given up.
  void discard_delivered();

  /// Counts a scan that `next` has given as skipped after all: the run is paused.
  /// @param reason, why  for people, why that is.
  void leave_out(const ReadyScan& scan, SkipReason reason = SkipReason::kPaused,
                 const std::string& why = "the mapping is paused");

  /// No more messages come: scans whose transforms did not come are skipped, the others stay for
  /// `next`.
  void finish();

  /// The user has ended the run: all that waits is skipped, and nothing is left for `next`.
  void interrupt();

  /// Those skipped since the last call, oldest first.
  [[nodiscard]] std::vector<SkippedScan> take_skipped();

  /// What was found odd about scans since the last call and what is done about it, for people.
  [[nodiscard]] std::vector<std::string> take_news() { return std::exchange(news_, {}); }

  [[nodiscard]] const ScanAccount& account() const { return account_; }
  /// Scans that were neither delivered nor skipped yet.
  [[nodiscard]] std::size_t waiting() const { return waiting_.size() + ready_scans_; }
  /// What is known of the lasers' sweeps.
  [[nodiscard]] const SweepTimes& sweep_times() const { return sweep_times_; }
  [[nodiscard]] const TransformStore& transforms() const { return transforms_.store(); }
  [[nodiscard]] const ScanQueueSettings& settings() const { return settings_; }

 private:
  struct WaitingScan {
    ros::Time arrival;
    std::string frame;
    LaserScan scan;
    double sent_increment = 0.0;             ///< [s] between beams, by the message
    double sent_scan_time = 0.0;             ///< [s]
    bool has_times = false;                  ///< as of ScanMessage
    std::optional<PlacedLaser> placed = {};  ///< when it is known
    bool was_kept_back = false;              ///< until it was told whether one is a part of a turn
  };
  /// The order in which scans come out: by stamp; of one stamp, the first laser's last, so that it
  /// is matched with the others'.
  struct Turn {
    ros::Time stamp;
    int laser = 0;

    [[nodiscard]] bool operator<(const Turn& other) const {
      return stamp < other.stamp || (stamp == other.stamp && laser > other.laser);
    }
  };
  using Waiting = std::map<Turn, WaitingScan>;
  /// Of the turns of one laser, where they come in parts.
  struct Parts {
    ScanJoiner joiner;
    ros::Time stamp = {};  ///< of the latest message, as the next
    std::string frame = {};
    double scan_time = 0.0;  ///< [s]
    bool has_times = false;
    Turn latest = {};  ///< of those that were whole
  };
  void advance(const ros::Time& now);
  void jump_back(double seconds, const ros::Time& now);
  void add_valid_scan(WaitingScan&& scan, const Turn& turn);
  void add_joined(const ScanMessage& message, int laser);
  void take_joined(Parts& parts, int laser);
  void skip_parts(SkipReason reason, const std::string& why);
  void choose_sweep_time(const Turn& turn, WaitingScan& waiting);
  void collect_ready(bool wait_for_more);
  const ScanInput* deliver(const Turn& turn, ReadyScan&& scan);
  void limit_waiting();
  void give_up_late();
  [[nodiscard]] std::deque<Item>::const_iterator oldest_ready_scan() const;
  void drop_oldest_ready(SkipReason reason, const std::string& why);
  void leave_out_oldest_ready(SkipReason reason, const std::string& why);
  void drop_all_ready(SkipReason reason, const std::string& why);
  [[nodiscard]] bool is_its_turn(const Turn& turn, const WaitingScan& scan) const;
  [[nodiscard]] bool may_be_part(const Turn& turn, const WaitingScan& scan) const;
  void skip(const ros::Time& stamp, SkipReason reason, const std::string& why);
  void tell(std::string news);

  void place(const Turn& turn, const BeamStamps& beams, WaitingScan& scan) const;
  [[nodiscard]] ReadyScan make_ready(const Turn& turn, const BeamStamps& beams,
                                     WaitingScan&& scan) const;

  ScanQueueSettings settings_;
  RobotTransforms transforms_;
  ScanStamps stamps_;
  Waiting waiting_;
  std::optional<ros::Time> now_;
  std::deque<Item> ready_;
  std::size_t ready_scans_ = 0;  ///< of the items in `ready_`
  std::optional<Turn> last_ready_;
  bool stopped_ = false;
  ScanAccount account_;
  std::vector<SkippedScan> skipped_;
  std::map<int, Parts> parts_;  ///< by laser, as the next
  SweepTimes sweep_times_;
  std::vector<std::string> news_;
};

}  // namespace matchbox_slam
