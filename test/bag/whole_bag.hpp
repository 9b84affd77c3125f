#pragma once

#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/MultiEchoLaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <string>
#include <vector>

#include "bag/bag_reader.hpp"
#include "ros/messages.hpp"

namespace matchbox_slam {

/// The small bag with a message of every type that is read, twice a second, and /tf_static.
inline void write_whole_bag(const std::string& path, const SmallBag& recipe = {}) {
  write_small_bag(path, recipe);
  rosbag::Bag bag(path, rosbag::bagmode::Append);
  const ros::Time begin(recipe.begin);
  bag.write("/tf_static", begin, make_link(recipe.begin, "base_link", "camera", 1.0));
  for (int k = 0; k < 2; ++k) {
    const ros::Time time = begin + ros::Duration(0.5 * k);
    sensor_msgs::MultiEchoLaserScan echoes;
    echoes.header.stamp = time;
    echoes.header.frame_id = "laser";
    echoes.ranges.resize(3);
    echoes.ranges[1].echoes = {1.0F, 2.0F};
    bag.write("/echoes", time, echoes);
    sensor_msgs::PointCloud2 cloud;
    cloud.header = echoes.header;
    sensor_msgs::PointCloud2Modifier modifier(cloud);
    modifier.setPointCloud2FieldsByString(1, "xyz");
    modifier.resize(5);
    bag.write("/points", time, cloud);
    sensor_msgs::Imu imu;
    imu.header = echoes.header;
    imu.orientation.w = 1.0;
    imu.linear_acceleration_covariance[8] = 0.5;
    bag.write("/imu", time, imu);
    nav_msgs::Odometry odometry;
    odometry.header = echoes.header;
    odometry.child_frame_id = "base_link";
    odometry.pose.pose.position.x = 0.25 * k;
    odometry.twist.covariance[35] = 0.125;
    bag.write("/odom", time, odometry);
  }
}

/// A message in words that differ where anything of it does.
struct Said {
  ros::Time time;
  std::string topic;
  std::string bytes;
};

inline bool operator==(const Said& a, const Said& b) {
  return a.time == b.time && a.topic == b.topic && a.bytes == b.bytes;
}

/// All messages of a recording, or those until it is damaged.
inline std::vector<Said> all_of(const std::vector<std::string>& paths,
                                std::string* damage = nullptr) {
  std::vector<Said> all;
  const BagReader reader(paths);
  const auto stream = reader.messages([](const BagConnection& /*all*/) { return true; }, {});
  try {
    while (const auto message = stream->next()) {
      std::string bytes;
      std::visit(
          [&bytes](const auto& content) {
            bytes.resize(ros::serialization::serializationLength(*content));
            ros::serialization::OStream out(reinterpret_cast<std::uint8_t*>(bytes.data()),
                                            static_cast<std::uint32_t>(bytes.size()));
            ros::serialization::serialize(out, *content);
          },
          message->content);
      all.push_back({message->time, message->connection->topic, bytes});
    }
  } catch (const BagError& error) {
    if (damage == nullptr) {
      throw;
    }
    *damage = error.what();
  }
  return all;
}

}  // namespace matchbox_slam
