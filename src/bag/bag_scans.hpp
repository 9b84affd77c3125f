#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bag/bag_motion.hpp"
#include "bag/bag_reader.hpp"
#include "bag/bag_survey.hpp"
#include "matchbox_slam/common/parameters.hpp"
#include "ros/scan_queue.hpp"
#include "run/run_dialog.hpp"
#include "run/run_options.hpp"

namespace matchbox_slam {

/// The recording that is asked for; what is not given is found in the bag.
struct BagRequest {
  std::vector<std::string> bags;
  std::vector<std::string> scan_topics;
  std::optional<std::string> base_frame;
  std::optional<std::string> odom_frame;
  bool no_odometry = false;
  std::optional<std::string> odom_topic;
  std::vector<std::string> laser_poses;  ///< each X,Y,YAW, in the order of the scan topics
  BagPeriod period;
  int threads = 1;  ///< from 2 on, the bag is read by a thread of its own
  /// Of a node, which went by the scans before each: nothing of a scan is known before it comes.
  bool is_repetition = false;
};

/// The frames and the like that were asked for as parameters, which have the same meaning. Throws
/// ConfigurationError.
[[nodiscard]] Parameters frame_parameters(const BagRequest& request);

/// What was found in a bag, and what happened while reading it.
struct BagFacts {
  std::vector<std::string> bags;
  std::vector<std::string> scan_topics;
  double seconds = 0.0;  ///< from the first scan's recording to the last one's
  int threads = 1;
  double scan_time_offset = 0.0;                 ///< [s] that was applied
  std::optional<double> estimated_clock_offset;  ///< [s]
  std::optional<double> no_return_from;          ///< [m], as find_no_returns
  std::string ignored_map_link;                  ///< empty: none
  std::size_t invalid_transforms = 0;
  std::size_t invalid_odometry = 0;  ///< messages on its topic
  bool interrupted = false;
  std::string damage;  ///< why reading ended early; empty: it did not
};

/// The scans of a recording with all that the engine needs, in the order of their stamps, from one
/// topic, with tf from the same recording. Says what it chooses, what is unusual about the bag, and
/// how far it has got; warns once of every reason for which scans are skipped.
class BagScans {
 public:
  /// Opens the bags. Throws as BagReader does.
  /// @param request, dialog  outlive this object.
  BagScans(const BagRequest& request, const RunDialog& dialog);

  /// Finds topics, frames and the offset between the clocks; to be called once, before `next`.
  /// Returns the options with the topics and frames in use.
  /// @param parameters  those given; a frame that is not among them is chosen.
  /// @param options     read from the parameters.
  /// Throws ConfigurationError when there is no answer or more than one, and BagError when the
  /// period has no scans; Interrupted when the user does not wait for that.
  [[nodiscard]] RunOptions prepare(const Parameters& parameters, RunOptions options);

  /// Events that come before certain scans, in their order.
  void schedule(std::vector<TimedEvent> events);

  /// The next scan, time jump or event; after a jump that stops, nothing more is read. None: the
  /// bag is at its end, damaged from here on, or the user has interrupted it, as the facts tell.
  [[nodiscard]] std::optional<ScanQueue::Item> next();

  /// What was asked for and has not been delivered yet.
  [[nodiscard]] BagPeriod rest() const;

  /// Whether a bag begins between scans of these stamps [s].
  [[nodiscard]] bool begins_bag(double before, double stamp) const {
    constexpr double kLatency = 1.0;  // [s] from a scan's stamp to its recording
    return reader_.has_begin_between(before, stamp + kLatency);
  }

  /// Counts the scans delivered so far as skipped: what came of them is given up.
  void discard_delivered() { queue_->discard_delivered(); }

  /// As ScanQueue::leave_out and set_limits.
  void leave_out(const ReadyScan& scan) { queue_->leave_out(scan); }
  void set_limits(double max_lag, double max_tilt) { queue_->set_limits(max_lag, max_tilt); }

  /// Events that no scan has come after yet.
  [[nodiscard]] std::size_t events_left() const { return events_.size(); }

  [[nodiscard]] const BagFacts& facts() const { return facts_; }
  [[nodiscard]] const ScanAccount& account() const { return queue_->account(); }

  /// Throws BagError, telling why no scan could be used, or Interrupted.
  [[noreturn]] void throw_nothing_used() const;

 private:
  [[nodiscard]] std::string text_of_topics() const;
  void choose_clock(const BagSurvey& survey, const RunOptions& options);
  [[nodiscard]] std::map<int, double> shown_sweeps(const ScanQueueSettings& settings,
                                                   const RunOptions& options,
                                                   const CloudOptions& cloud) const;
  void leave_out_next(const ScanMoment& moment);
  [[nodiscard]] BagMotion motion_before_damage(const BagSurvey& survey, const AskedFrames& asked,
                                               const RunOptions& options) const;
  [[nodiscard]] bool is_event_due(const ScanQueue::Item& next) const;
  void stop();
  void read_message();
  void take(const BagMessage& message);
  void warn_of_skipped();
  void warn_of_map_link();
  void warn_of_ignored(const std::string& whose, const std::string& defect);
  void show_progress(const ros::Time& time);
  void require_not_interrupted() const;

  const BagRequest& request_;
  const RunDialog& dialog_;
  BagReader reader_;
  BagFacts facts_;
  std::optional<ScanQueue> queue_;
  std::unique_ptr<BagStream> stream_;  ///< null when there is no more to read
  std::set<SkipReason> told_;
  std::string first_skip_;            ///< since time has jumped back last
  std::size_t used_before_jump_ = 0;  ///< scans, until then
  bool told_of_map_link_ = false;
  std::set<std::string> told_of_ignored_;  ///< whose messages
  std::optional<ros::Time> first_time_;
  ros::Time delivered_time_;  ///< latest recording of a scan that was delivered
  std::deque<TimedEvent> events_;
  int time_jumps_ = 0;
};

}  // namespace matchbox_slam
