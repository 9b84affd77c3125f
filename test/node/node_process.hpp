#pragma once

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Log.h>
#include <sensor_msgs/LaserScan.h>
#include <std_srvs/Trigger.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "ros/messages.hpp"

namespace matchbox_slam {

/// Looks again and again until it is so, or until it should long have been.
inline bool wait_until(const std::function<bool()>& is_so) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!is_so() && std::chrono::steady_clock::now() < end) {
    ros::spinOnce();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return is_so();
}

/// A robot that creeps through a room. Its time goes on by steps, however long they take.
class Robot {
 public:
  Robot()
      : scans_(node_.advertise<sensor_msgs::LaserScan>("/scan", 10000)),
        transforms_(node_.advertise<tf2_msgs::TFMessage>("/tf", 10000)),
        poses_(node_.subscribe("/pose", 100, &Robot::on_pose, this)) {}

  [[nodiscard]] bool is_heard() const {
    return scans_.getNumSubscribers() > 0 && transforms_.getNumSubscribers() > 0 &&
           poses_.getNumPublishers() > 0;
  }

  /// One scan and the transforms around it.
  void step(std::size_t beams = 90) {
    stamp_ += 0.05;
    scans_.publish(make_scan(stamp_, "laser", beams));
    for (const double stamp : {stamp_ - 0.01, stamp_ + 0.01}) {
      transforms_.publish(
          make_transforms({make_transform(stamp, "odom", "base", 0.5 * (stamp - begin_)),
                           make_transform(stamp, "base", "laser", 0.2)}));
    }
  }

  /// Time goes on, and the robot stands still.
  void rest(double seconds) {
    stamp_ += seconds;
    begin_ += seconds;
  }

  /// Steps until this many more poses came back.
  bool drive(int poses) {
    const int wanted = poses_heard_ + poses;
    return wait_until([&] {
      if (poses_heard_ < wanted) {
        step();
      }
      return poses_heard_ >= wanted;
    });
  }

 private:
  static constexpr double kBegin = 1000.0;

  void on_pose(const geometry_msgs::PoseWithCovarianceStamped& /*message*/) { ++poses_heard_; }

  ros::NodeHandle node_;
  ros::Publisher scans_;
  ros::Publisher transforms_;
  ros::Subscriber poses_;
  double begin_ = kBegin;  ///< from where on it would have driven without a rest
  double stamp_ = kBegin;
  std::atomic<int> poses_heard_{0};
};

/// A program, killed with this object at the latest.
class Process {
 public:
  explicit Process(const std::vector<std::string>& arguments) {
    std::vector<char*> pointers;
    for (const std::string& argument : arguments) {
      pointers.push_back(const_cast<char*>(argument.c_str()));
    }
    pointers.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ == 0) {
      std::signal(SIGXFSZ, SIG_IGN);  // so that writing fails instead, as on a disk that is full
      ::execvp(pointers[0], pointers.data());
      ::_exit(127);
    }
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process() {
    if (!status_) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
  }

  void set_largest_file(rlim_t bytes) const {
    const rlimit limit{bytes, RLIM_INFINITY};
    ASSERT_EQ(::prlimit(pid_, RLIMIT_FSIZE, &limit, nullptr), 0);
  }

  /// What it exits with after a signal; -1 when it does not, or dies of it.
  int exit_code_after(int signal) {
    ::kill(pid_, signal);
    wait_until([&] {
      int status = 0;
      if (!status_ && ::waitpid(pid_, &status, WNOHANG) == pid_) {
        status_ = status;
      }
      return status_.has_value();
    });
    return status_ && WIFEXITED(*status_) ? WEXITSTATUS(*status_) : -1;
  }

 private:
  pid_t pid_ = -1;
  std::optional<int> status_;
};

/// slam_node as a process of its own, in which no file can be too large but by `set_largest_file`.
class NodeProcess : public Process {
 public:
  NodeProcess(const std::string& name, const TemporaryFolder& folder,
              const std::vector<std::string>& more_arguments = {})
      : Process([&] {
          std::vector<std::string> arguments = {MATCHBOX_SLAM_NODE,
                                                "__name:=" + name,
                                                "_base_frame:=base",
                                                "_trajectory_file:=" + (folder / "node.tum"),
                                                "_map_file:=" + (folder / "map"),
                                                "_slam/insert_distance:=0"};
          arguments.insert(arguments.end(), more_arguments.begin(), more_arguments.end());
          return arguments;
        }()) {}
};

/// The last of the log lines that hold these words; empty while there is none. To be made before
/// the node that is listened to.
class LogWatch {
 public:
  explicit LogWatch(std::string words) : words_(std::move(words)) {
    EXPECT_TRUE(wait_until([this] { return log_.getNumPublishers() > 0; }));  // this program's
    before_ = log_.getNumPublishers();
  }

  [[nodiscard]] std::string line() const { return line_; }

  /// Waits until the node is heard: what it says before is lost, but for its newest line.
  [[nodiscard]] bool hears_the_node() const {
    return wait_until([this] { return log_.getNumPublishers() > before_; });
  }

 private:
  void on_log(const rosgraph_msgs::Log& log) {
    if (contains(log.msg, words_)) {
      line_ = log.msg;
    }
  }

  ros::NodeHandle node_;
  std::string words_;
  std::string line_;
  ros::Subscriber log_ = node_.subscribe("/rosout", 1000, &LogWatch::on_log, this);
  std::uint32_t before_ = 0;
};

inline std_srvs::Trigger::Response save(const std::string& node) {
  std_srvs::Trigger service;
  EXPECT_TRUE(ros::service::call("/" + node + "/save_map", service));
  return service.response;
}

}  // namespace matchbox_slam
