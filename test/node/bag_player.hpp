#pragma once

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/ros.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MultiEchoLaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <thread>

namespace matchbox_slam {

/// Looks again and again until it is so, or until it should long have been.
inline bool wait_until_so(const std::function<bool()>& is_so) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!is_so() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return is_so();
}

/// Plays a bag to the node, as far as it is told to.
class Player {
 public:
  explicit Player(const std::string& bag)
      : bag_(bag, rosbag::bagmode::Read), view_(bag_), next_(view_.begin()) {}

  [[nodiscard]] bool is_at_end() { return next_ == view_.end(); }

  [[nodiscard]] bool is_heard() const {
    return scans_.getNumSubscribers() + echoes_.getNumSubscribers() + clouds_.getNumSubscribers() >
               0 &&
           transforms_.getNumSubscribers() > 0 && poses_.getNumPublishers() > 0;
  }

  /// Publishes so many scans, with all that was recorded before the last of them.
  void play(int scans) {
    for (; next_ != view_.end() && scans > 0; ++next_) {
      if (const auto scan = next_->instantiate<sensor_msgs::LaserScan>()) {
        scans_.publish(scan);
        --scans;
      } else if (const auto echoes = next_->instantiate<sensor_msgs::MultiEchoLaserScan>()) {
        echoes_.publish(echoes);
        --scans;
      } else if (const auto cloud = next_->instantiate<sensor_msgs::PointCloud2>()) {
        clouds_.publish(cloud);
        --scans;
      } else if (const auto imu = next_->instantiate<sensor_msgs::Imu>()) {
        imus_.publish(imu);
      } else if (const auto transforms = next_->instantiate<tf2_msgs::TFMessage>()) {
        transforms_.publish(transforms);
      }
    }
  }

  /// Publishes until so many more poses have come back.
  bool drive(int poses) {
    const int wanted = heard_ + poses;
    return wait_until_so([&] {
      if (heard_ < wanted) {
        play(1);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
      return heard_ >= wanted;
    });
  }

  [[nodiscard]] int heard() const { return heard_; }

 private:
  void on_pose(const geometry_msgs::PoseWithCovarianceStamped& /*message*/) { ++heard_; }

  ros::NodeHandle node_;
  ros::Publisher scans_ = node_.advertise<sensor_msgs::LaserScan>("/scan", 1000);
  ros::Publisher echoes_ = node_.advertise<sensor_msgs::MultiEchoLaserScan>("/echoes", 1000);
  ros::Publisher clouds_ = node_.advertise<sensor_msgs::PointCloud2>("/points", 1000);
  ros::Publisher transforms_ = node_.advertise<tf2_msgs::TFMessage>("/tf", 1000);
  ros::Publisher imus_ = node_.advertise<sensor_msgs::Imu>("/imu", 1000);
  ros::Subscriber poses_ = node_.subscribe("/pose", 1000, &Player::on_pose, this);
  rosbag::Bag bag_;
  rosbag::View view_;
  rosbag::View::iterator next_;
  std::atomic<int> heard_{0};
};

}  // namespace matchbox_slam
