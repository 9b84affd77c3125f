#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/service_client.h>
#include <ros/spinner.h>
#include <ros/subscriber.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "matchbox_slam/LikelyPoses.h"
#include "matchbox_slam/MatchInfo.h"
#include "matchbox_slam/Relocalise.h"
#include "rviz/slam_report.hpp"

namespace matchbox_slam {

/// What a client knows at a moment.
struct SlamView {
  std::string node;  ///< its full name
  SlamReport report;
  std::vector<std::string> matchers;  ///< to choose from, by their short names
  std::string matcher;                ///< in use
  std::string map_file;               ///< where maps are saved
  std::vector<Place> places;          ///< of the newest relocalisation, best first
  std::string doing;                  ///< what is being asked of the node; empty: nothing
  std::size_t answers = 0;            ///< so far
  std::string answer;                 ///< the newest one, for people
  bool succeeded = true;              ///< what was asked for then
};

/// Listens to a SLAM node and asks things of it, in threads of its own: nothing here waits for the
/// node. What it answers `view` tells.
class SlamClient {
 public:
  /// @param node  its name, such as "/slam"; a relative one is in this program's namespace. Throws
  ///              ros::InvalidNameException.
  explicit SlamClient(const std::string& node);

  /// Gives up what is being asked for.
  ~SlamClient();

  SlamClient(const SlamClient&) = delete;
  SlamClient& operator=(const SlamClient&) = delete;

  [[nodiscard]] SlamView view() const;

  void choose_matcher(const std::string& matcher);
  /// @param file  with or without an extension; empty: where maps were saved before. Further maps
  ///              are saved there, too.
  void save_map(const std::string& file);
  /// @param file  of a saved map; without an extension: .slam.
  void load_map(const std::string& file);
  void set_paused(bool paused);
  void reset();
  /// Asks where the newest scan may have been taken. The places are also published as markers, on
  /// `places` in the node's namespace.
  void relocalise();
  /// Says that the robot was at one of these places. @param index  from 0 on.
  void choose_place(std::size_t index);

 private:
  using Clock = std::chrono::steady_clock;
  /// Asks, and returns the answer for people. Throws std::exception with why it is none.
  using Question = std::function<std::string()>;

  void ask(const std::string& doing, Question question);
  void run();
  template <typename Service>
  void call(const std::string& name, Service& service);
  void set_parameter(const std::string& name, const std::string& value);
  void show_places(const Relocalise::Response& found);
  void forget_places();
  void publish_places() const;

  void on_match(const MatchInfo& match);
  void on_likely(const LikelyPoses& likely);
  void on_diagnostics(const diagnostic_msgs::DiagnosticArray& array);
  void on_descriptions(const dynamic_reconfigure::ConfigDescription& descriptions);
  void on_parameters(const dynamic_reconfigure::Config& parameters);

  const std::string node_;

  mutable std::mutex mutex_;  ///< guards what follows, up to the thread
  SlamView view_;
  Clock::time_point match_time_;  ///< when that came; likewise below
  Clock::time_point loop_time_;
  Clock::time_point diagnostics_time_;
  std::string map_frame_ = "map";
  ros::Time places_stamp_;  ///< of the scan that may have been taken there
  bool is_ending_ = false;
  std::deque<std::pair<std::string, Question>> questions_;
  ros::ServiceClient called_;  ///< while it is
  std::condition_variable asked_;

  ros::CallbackQueue callbacks_;
  ros::NodeHandle handle_;
  ros::Publisher places_;
  std::vector<ros::Subscriber> subscribers_;
  ros::AsyncSpinner spinner_;
  std::thread thread_;  ///< last: it uses all of the above
};

}  // namespace matchbox_slam
