#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MultiEchoLaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace matchbox_slam {

/// One recorder's messages on one topic.
struct BagConnection {
  std::string topic;
  std::string type;    ///< by its name in ROS 1, such as "sensor_msgs/LaserScan"
  std::string md5sum;  ///< of the type's definition; empty where a recording tells none
  std::size_t messages = 0;
};

/// Messages of some connections, from one time to another, both included.
struct BagSelection {
  std::set<std::uint32_t> connections;
  ros::Time first;
  ros::Time last = ros::TIME_MAX;
};

/// A message of a type that is read, whatever the format of the file.
using MessageContent =
    std::variant<sensor_msgs::LaserScan::ConstPtr, sensor_msgs::MultiEchoLaserScan::ConstPtr,
                 sensor_msgs::PointCloud2::ConstPtr, tf2_msgs::TFMessage::ConstPtr,
                 sensor_msgs::Imu::ConstPtr, nav_msgs::Odometry::ConstPtr>;

struct RecordedMessage {
  ros::Time time;  ///< at which it was recorded
  const BagConnection* connection = nullptr;
  MessageContent content;
};

/// Messages of a file in the order of time; those of one time in the order of the file.
class RecordedMessages {
 public:
  RecordedMessages() = default;
  RecordedMessages(const RecordedMessages&) = delete;
  RecordedMessages& operator=(const RecordedMessages&) = delete;
  virtual ~RecordedMessages() = default;

  /// When the next one was recorded; none at the end. Throws BagError where the file is damaged.
  [[nodiscard]] virtual std::optional<ros::Time> peek() = 0;

  /// The next one, where `peek` says that there is one. Throws BagError where it is damaged.
  [[nodiscard]] virtual RecordedMessage next() = 0;
};

/// A file with a recording or a part of one, in any format: what is in it, and its messages.
class RecordingFile {
 public:
  explicit RecordingFile(std::string path) : path_(std::move(path)) {}
  RecordingFile(const RecordingFile&) = delete;
  RecordingFile& operator=(const RecordingFile&) = delete;
  virtual ~RecordingFile() = default;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] virtual const std::map<std::uint32_t, BagConnection>& connections() const = 0;
  [[nodiscard]] virtual bool empty() const = 0;
  /// When the first and the last message were recorded, of a file that is not empty.
  [[nodiscard]] virtual ros::Time begin_time() const = 0;
  [[nodiscard]] virtual ros::Time end_time() const = 0;

  /// What a person should know of how the file is read, whole sentences that name it.
  [[nodiscard]] virtual std::vector<std::string> remarks() const { return {}; }

  /// The file outlives its messages. Where it is cut off, BagError comes after what there is.
  [[nodiscard]] virtual std::unique_ptr<RecordedMessages> messages(
      BagSelection selection) const = 0;

 private:
  std::string path_;
};

}  // namespace matchbox_slam
