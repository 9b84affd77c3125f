#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <tf2_msgs/TFMessage.h>

#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "bag/bag_error.hpp"
#include "bag/recording_file.hpp"
#include "ros/scan_message.hpp"

namespace matchbox_slam {

/// Whether a topic is tf, by either spelling.
[[nodiscard]] bool is_transform_topic(const std::string& topic);
[[nodiscard]] bool is_static_transform_topic(const std::string& topic);

struct BagTopic {
  std::string name;
  std::string type;  ///< such as "sensor_msgs/LaserScan"
  std::size_t messages = 0;
};

/// A transform message and where it came from.
struct BagTransforms {
  tf2_msgs::TFMessage::ConstPtr message;
  bool is_static = false;
};

struct BagMessage {
  ros::Time time;  ///< at which it was recorded
  std::variant<ScanMessage, BagTransforms, sensor_msgs::Imu::ConstPtr, nav_msgs::Odometry::ConstPtr>
      content;
  int laser = 0;  ///< of a scan: number of its topic among those asked for
};

/// Part of a bag, in seconds from its first message.
struct BagPeriod {
  double start = 0.0;
  double duration = std::numeric_limits<double>::infinity();
};

/// Messages in the order in which they were recorded.
class BagStream {
 public:
  virtual ~BagStream() = default;

  /// None at the end. Throws BagError where the bag is damaged.
  [[nodiscard]] virtual std::optional<BagMessage> next() = 0;
};

/// The same as they were recorded.
class MessageStream {
 public:
  virtual ~MessageStream() = default;

  /// None at the end. Throws BagError where the bag is damaged.
  [[nodiscard]] virtual std::optional<RecordedMessage> next() = 0;
};

/// One recording, in one file or split into several, of any format that open_recording knows. Reads
/// bags chunk by chunk, the index too.
class BagReader {
 public:
  /// Throws ConfigurationError for a file that is missing or named twice and BagError for one that
  /// is empty, damaged at its beginning, or no recording that can be read.
  explicit BagReader(const std::vector<std::string>& paths);
  ~BagReader();
  BagReader(const BagReader&) = delete;
  BagReader& operator=(const BagReader&) = delete;

  /// Sorted by name.
  [[nodiscard]] const std::vector<BagTopic>& topics() const { return topics_; }

  /// Names of the topics that carry messages of a type, such as "sensor_msgs/LaserScan".
  [[nodiscard]] std::vector<std::string> topics_of(const std::string& type) const;

  /// The type of a topic that there is.
  [[nodiscard]] std::string type_of(const std::string& topic) const;

  [[nodiscard]] ros::Time begin_time() const { return begin_; }
  /// Whether one of the bags begins between two times [s].
  [[nodiscard]] bool has_begin_between(double from, double to) const;
  [[nodiscard]] ros::Time end_time() const { return end_; }

  /// What a person should know of files that hold scans of one of these topics at the same time,
  /// as two drives do, or two recordings of one; empty: there are none.
  [[nodiscard]] std::string text_of_overlap(const std::vector<std::string>& scan_topics) const;

  /// Scans of these topics together with /tf and /tf_static of the period. What was said on
  /// /tf_static before the period comes first. The reader outlives its streams; one is read at a
  /// time.
  /// @param imu_topic  of sensor_msgs/Imu, read as well; empty: none.
  /// @param cloud      how clouds become scans.
  /// @param odom_topic of nav_msgs/Odometry, read as well; empty: none.
  [[nodiscard]] std::unique_ptr<BagStream> stream(const std::vector<std::string>& scan_topics,
                                                  const BagPeriod& period,
                                                  const std::string& imu_topic = {},
                                                  const CloudOptions& cloud = {},
                                                  const std::string& odom_topic = {}) const;

  /// All messages of the topics that are asked for, of the types of MessageContent, with what was
  /// said on /tf_static before the period first.
  [[nodiscard]] std::unique_ptr<MessageStream> messages(
      const std::function<bool(const BagConnection&)>& is_asked, const BagPeriod& period) const;

  /// What a person should know of how the files are read, whole sentences.
  [[nodiscard]] std::vector<std::string> remarks() const;

 private:
  std::vector<std::unique_ptr<RecordingFile>> bags_;
  std::vector<std::string> remarks_;  ///< of files that are left out
  std::vector<ros::Time> begins_;     ///< of the bags
  std::vector<BagTopic> topics_;
  ros::Time begin_;
  ros::Time end_;
};

/// The same stream, read ahead by a thread of its own that holds up to `capacity` messages.
[[nodiscard]] std::unique_ptr<BagStream> read_ahead(std::unique_ptr<BagStream> stream,
                                                    std::size_t capacity);

}  // namespace matchbox_slam
