#include "bag/bag_reader.hpp"

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {

namespace {

bool is_transform_topic(const std::string& topic) { return topic == "/tf" || topic == "tf"; }
bool is_static_transform_topic(const std::string& topic) {
  return topic == "/tf_static" || topic == "tf_static";
}

void skip_header(ByteReader& bytes) {
  (void)bytes.take(3, sizeof(std::uint32_t));  // number and stamp
  (void)bytes.array();                         // frame
}

// Messages are taken apart here before roscpp does it, which gets the memory for as many elements
// as a message says it has before it looks whether they are there.

void check_bytes(ByteReader bytes, const sensor_msgs::LaserScan& /*type*/) {
  skip_header(bytes);
  (void)bytes.take(7, sizeof(float));  // angles, times and limits
  (void)bytes.array(sizeof(float));    // ranges
  (void)bytes.array(sizeof(float));    // intensities
}

void check_bytes(ByteReader bytes, const sensor_msgs::MultiEchoLaserScan& /*type*/) {
  skip_header(bytes);
  (void)bytes.take(7, sizeof(float));     // angles, times and limits
  for (int part = 0; part < 2; ++part) {  // ranges, then intensities
    for (auto beams = bytes.number<std::uint32_t>(); beams > 0; --beams) {
      (void)bytes.array(sizeof(float));
    }
  }
}

void check_bytes(ByteReader bytes, const sensor_msgs::PointCloud2& /*type*/) {
  constexpr std::size_t kFieldBytes = 9;  // offset, datatype and count
  skip_header(bytes);
  (void)bytes.take(2, sizeof(std::uint32_t));  // height and width
  for (auto fields = bytes.number<std::uint32_t>(); fields > 0; --fields) {
    (void)bytes.array();  // name
    (void)bytes.take(kFieldBytes);
  }
  (void)bytes.take(1);                         // byte order
  (void)bytes.take(2, sizeof(std::uint32_t));  // point_step and row_step
  (void)bytes.array();                         // data
  (void)bytes.take(1);                         // is_dense
}

void check_bytes(ByteReader bytes, const sensor_msgs::Imu& /*type*/) {
  skip_header(bytes);
  (void)bytes.take(37, sizeof(double));  // orientation, rates, accelerations, their covariances
}

void check_bytes(ByteReader bytes, const nav_msgs::Odometry& /*type*/) {
  skip_header(bytes);
  (void)bytes.array();                   // child frame
  (void)bytes.take(85, sizeof(double));  // pose and twist, each with a covariance
}

void check_bytes(ByteReader bytes, const tf2_msgs::TFMessage& /*type*/) {
  for (auto left = bytes.number<std::uint32_t>(); left > 0; --left) {
    skip_header(bytes);
    (void)bytes.array();                  // child frame
    (void)bytes.take(7, sizeof(double));  // translation and rotation
  }
}

/// Reads a message of a topic. Throws BagError when its bytes are none of this type.
template <typename Message>
boost::shared_ptr<Message> deserialize(ByteReader bytes, const BagConnection& connection) {
  if (connection.md5sum != ros::message_traits::md5sum<Message>()) {
    throw BagError("topic " + connection.topic + " of the bag holds " + connection.type +
                   " in a definition that is not the one of " +
                   ros::message_traits::datatype<Message>());
  }
  auto message = boost::make_shared<Message>();
  check_bytes(bytes, *message);
  // roscpp reads from what it could write to. NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast)
  ros::serialization::IStream stream(const_cast<std::uint8_t*>(bytes.data()),
                                     static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::deserialize(stream, *message);
  return message;
}

ScanMessage read_scan(const ByteReader& bytes, const BagConnection& connection,
                      const CloudOptions& cloud) {
  if (connection.type == ros::message_traits::datatype<sensor_msgs::MultiEchoLaserScan>()) {
    return to_scan(*deserialize<sensor_msgs::MultiEchoLaserScan>(bytes, connection));
  }
  if (connection.type == ros::message_traits::datatype<sensor_msgs::PointCloud2>()) {
    return to_scan(*deserialize<sensor_msgs::PointCloud2>(bytes, connection), cloud);
  }
  return to_scan(
      sensor_msgs::LaserScan::ConstPtr(deserialize<sensor_msgs::LaserScan>(bytes, connection)));
}

/// Which messages are asked for, and how they are read.
struct BagAsked {
  std::vector<std::string> scan_topics;
  std::string imu_topic;
  CloudOptions cloud;
  std::string odom_topic;

  [[nodiscard]] bool has(const std::string& topic) const {
    return is_transform_topic(topic) || is_static_transform_topic(topic) || topic == imu_topic ||
           topic == odom_topic ||
           std::find(scan_topics.begin(), scan_topics.end(), topic) != scan_topics.end();
  }
};

/// The first of those that are to come of several bags; of one time that of the first bag.
struct NextEntry {
  std::size_t bag = 0;
  const BagEntry* entry = nullptr;
};

NextEntry next_of(std::vector<BagEntries>& bags) {
  NextEntry next;
  for (std::size_t bag = 0; bag < bags.size(); ++bag) {
    const BagEntry* entry = bags[bag].peek();
    if (entry != nullptr && (next.entry == nullptr || entry->time < next.entry->time)) {
      next = {bag, entry};
    }
  }
  return next;
}

/// What was said on /tf_static before a period, and then the period.
class PeriodStream : public BagStream {
 public:
  PeriodStream(const std::vector<std::unique_ptr<BagFile>>& bags, const ros::Time& first,
               const ros::Time& last, BagAsked asked)
      : bags_(bags), asked_(std::move(asked)) {
    for (const auto& bag : bags_) {
      BagSelection before;
      BagSelection during{{}, first, last};
      for (const auto& [number, connection] : bag->connections()) {
        if (asked_.has(connection.topic)) {
          during.connections.insert(number);
        }
        if (is_static_transform_topic(connection.topic) && !first.isZero()) {
          before.connections.insert(number);
          before.last = first - ros::Duration(0, 1);
        }
      }
      before_.emplace_back(*bag, std::move(before));
      during_.emplace_back(*bag, std::move(during));
      readers_.emplace_back(*bag);
    }
  }

  std::optional<BagMessage> next() override {
    if (is_over_) {
      return std::nullopt;
    }
    is_over_ = true;  // should this fail
    try {
      std::optional<BagMessage> message = read_next(before_);
      if (!message) {
        message = read_next(during_);
      }
      if (message) {
        is_over_ = false;
        last_read_ = std::to_string(message->time.toSec()) + " s";
      }
      return message;
    } catch (const BagError&) {
      throw;
    } catch (const std::exception& error) {
      throw BagError("the bag is damaged after " + last_read_ + " (" + error.what() + ")");
    }
  }

 private:
  std::optional<BagMessage> read_next(std::vector<BagEntries>& entries) {
    const NextEntry next = next_of(entries);
    if (next.entry == nullptr) {
      return std::nullopt;
    }
    BagMessage message = read(next.bag, *next.entry);
    entries[next.bag].pop();
    return message;
  }

  BagMessage read(std::size_t bag, const BagEntry& entry) {
    const BagConnection& connection = bags_[bag]->connections().at(entry.connection);
    const ByteReader bytes = readers_[bag].read(entry);
    BagMessage message;
    message.time = entry.time;
    if (is_transform_topic(connection.topic) || is_static_transform_topic(connection.topic)) {
      message.content = BagTransforms{deserialize<tf2_msgs::TFMessage>(bytes, connection),
                                      is_static_transform_topic(connection.topic)};
    } else if (connection.topic == asked_.imu_topic) {
      message.content =
          sensor_msgs::Imu::ConstPtr(deserialize<sensor_msgs::Imu>(bytes, connection));
    } else if (connection.topic == asked_.odom_topic) {
      message.content =
          nav_msgs::Odometry::ConstPtr(deserialize<nav_msgs::Odometry>(bytes, connection));
    } else {
      const std::vector<std::string>& topics = asked_.scan_topics;
      message.content = read_scan(bytes, connection, asked_.cloud);
      message.laser = static_cast<int>(std::find(topics.begin(), topics.end(), connection.topic) -
                                       topics.begin());
    }
    return message;
  }

  const std::vector<std::unique_ptr<BagFile>>& bags_;
  BagAsked asked_;
  // Of each bag:
  std::vector<BagEntries> before_;
  std::vector<BagEntries> during_;
  std::vector<BagMessageReader> readers_;
  bool is_over_ = false;
  std::string last_read_ = "its beginning";
};

ros::Time seconds_after(const ros::Time& begin, double seconds) {
  const double latest = ros::TIME_MAX.toSec() - 1.0;
  const double longest = ros::DURATION_MAX.toSec() - 1.0;
  return seconds < longest && begin.toSec() + seconds < latest ? begin + ros::Duration(seconds)
                                                               : ros::TIME_MAX;
}

}  // namespace

BagReader::BagReader(const std::vector<std::string>& paths) {
  std::map<std::string, BagTopic> topics;
  std::set<std::string> seen;
  for (const std::string& path : paths) {
    if (!seen.insert(path).second) {
      throw ConfigurationError("bag '" + path + "' is named twice");
    }
    bags_.push_back(std::make_unique<BagFile>(path));
    const BagFile& bag = *bags_.back();
    if (bag.empty()) {
      throw BagError("bag '" + path + "' holds no messages");
    }
    for (const auto& [number, connection] : bag.connections()) {
      topics[connection.topic].name = connection.topic;
      topics[connection.topic].type = connection.type;
      topics[connection.topic].messages += connection.messages;
    }
    const ros::Time begin = bag.begin_time();
    begins_.push_back(begin);
    begin_ = bags_.size() == 1 ? begin : std::min(begin_, begin);
    end_ = std::max(end_, bag.end_time());
  }
  for (auto& [name, topic] : topics) {
    topics_.push_back(std::move(topic));
  }
}

BagReader::~BagReader() = default;

bool BagReader::has_begin_between(double from, double to) const {
  return std::any_of(begins_.begin(), begins_.end(), [&](const ros::Time& begin) {
    return from < begin.toSec() && begin.toSec() < to;
  });
}

std::vector<std::string> BagReader::topics_of(const std::string& type) const {
  std::vector<std::string> names;
  for (const BagTopic& topic : topics_) {
    if (topic.type == type) {
      names.push_back(topic.name);
    }
  }
  return names;
}

std::string BagReader::type_of(const std::string& topic) const {
  const auto found = std::find_if(topics_.begin(), topics_.end(),
                                  [&](const BagTopic& one) { return one.name == topic; });
  return found->type;
}

std::unique_ptr<BagStream> BagReader::stream(const std::vector<std::string>& scan_topics,
                                             const BagPeriod& period, const std::string& imu_topic,
                                             const CloudOptions& cloud,
                                             const std::string& odom_topic) const {
  const ros::Time first = seconds_after(begin_, period.start);
  const ros::Time last = seconds_after(first, period.duration);
  return std::make_unique<PeriodStream>(bags_, first, last,
                                        BagAsked{scan_topics, imu_topic, cloud, odom_topic});
}

}  // namespace matchbox_slam
