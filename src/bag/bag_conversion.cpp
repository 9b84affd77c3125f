#include "bag/bag_conversion.hpp"

#include <fmt/core.h>
#include <ros/message_traits.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <filesystem>
#include <set>
#include <variant>

#include "bag/bag_reader.hpp"
#include "bag/bag_survey.hpp"
#include "bag/bag_writer.hpp"
#include "common/interrupted.hpp"
#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {
namespace {

/// The scan topics to write: those that are asked for, else all that there are.
std::set<std::string> scan_topics_of(const BagReader& reader,
                                     const std::vector<std::string>& asked) {
  std::set<std::string> topics;
  if (!asked.empty()) {
    for (const std::string& topic : choose_scan_topics(reader, asked)) {
      topics.insert(topic);
    }
    return topics;
  }
  for (const std::string& type : scan_types()) {
    for (const std::string& topic : reader.topics_of(type)) {
      topics.insert(topic);
    }
  }
  if (topics.empty()) {
    throw ConfigurationError(text_of_no_scans(reader));
  }
  return topics;
}

/// Types of messages that are for a map, whatever the topic.
bool is_of_odometry(const BagConnection& connection) {
  return connection.type == ros::message_traits::datatype<nav_msgs::Odometry>() ||
         connection.type == ros::message_traits::datatype<sensor_msgs::Imu>();
}

/// What a recorder notes of a topic. Static transforms are latched, as their publisher has them, so
/// that who plays the bag sees them at any time.
template <typename Message>
boost::shared_ptr<ros::M_string> header_of(const std::string& topic) {
  auto header = boost::make_shared<ros::M_string>();
  (*header)["topic"] = topic;
  (*header)["type"] = ros::message_traits::datatype<Message>();
  (*header)["md5sum"] = ros::message_traits::md5sum<Message>();
  (*header)["message_definition"] = ros::message_traits::definition<Message>();
  (*header)["callerid"] = "/map_bag";
  (*header)["latching"] = is_static_transform_topic(topic) ? "1" : "0";
  return header;
}

void count(const MessageContent& content, ConvertedBag& converted) {
  if (std::holds_alternative<tf2_msgs::TFMessage::ConstPtr>(content)) {
    ++converted.transforms;
  } else if (std::holds_alternative<sensor_msgs::Imu::ConstPtr>(content) ||
             std::holds_alternative<nav_msgs::Odometry::ConstPtr>(content)) {
    ++converted.others;
  } else {
    ++converted.scans;
  }
}

/// Copies messages to a bag.
class BagCopy {
 public:
  BagCopy(const BagRequest& request, const BagReader& reader, const RunDialog& dialog)
      : request_(request), reader_(reader), dialog_(dialog) {}

  void write(MessageStream& stream, rosbag::Bag& bag, ConvertedBag& converted) {
    while (const std::optional<RecordedMessage> message = next_of(stream, converted)) {
      if (dialog_.is_interrupted()) {
        throw Interrupted("interrupted; nothing is written");
      }
      write(*message, bag);
      count(message->content, converted);
      show_progress(message->time, converted);
    }
  }

 private:
  /// None at the end, or where the recording is damaged.
  static std::optional<RecordedMessage> next_of(MessageStream& stream, ConvertedBag& converted) {
    try {
      return stream.next();
    } catch (const BagError& error) {
      converted.damage = error.what();
      return std::nullopt;
    }
  }

  static void write(const RecordedMessage& message, rosbag::Bag& bag) {
    const std::string& topic = message.connection->topic;
    std::visit(
        [&](const auto& content) {
          using Message = std::remove_const_t<std::remove_reference_t<decltype(*content)>>;
          bag.write(topic, message.time, *content, header_of<Message>(topic));
        },
        message.content);
  }

  void show_progress(const ros::Time& time, const ConvertedBag& converted) const {
    const double begin = reader_.begin_time().toSec() + request_.period.start;
    const double length = std::min(reader_.end_time().toSec() - begin, request_.period.duration);
    const double done = time.toSec() - begin;
    dialog_.show_progress(length > 0.0 ? std::clamp(done / length, 0.0, 1.0) : 1.0,
                          fmt::format("{} scans", converted.scans));
  }

  const BagRequest& request_;
  const BagReader& reader_;
  const RunDialog& dialog_;
};

}  // namespace

ConvertedBag convert_bag(const BagRequest& request, const std::string& path,
                         const RunDialog& dialog) {
  if (std::filesystem::exists(std::filesystem::symlink_status(path))) {
    throw ConfigurationError(
        fmt::format("--convert: there is '{}' already, which may be a recording; give the name of "
                    "a new file, or remove that one",
                    path));
  }
  const BagReader reader(request.bags);
  for (const std::string& remark : reader.remarks()) {
    dialog.warn(remark);
  }
  const std::set<std::string> scans = scan_topics_of(reader, request.scan_topics);
  const auto is_asked = [&scans](const BagConnection& connection) {
    return is_transform_topic(connection.topic) || is_static_transform_topic(connection.topic) ||
           is_of_odometry(connection) || scans.count(connection.topic) > 0;
  };
  const std::unique_ptr<MessageStream> stream = reader.messages(is_asked, request.period);
  ConvertedBag converted;
  BagWriter writer(path, rosbag::compression::Uncompressed);
  writer.write([&](rosbag::Bag& bag) {
    BagCopy(request, reader, dialog).write(*stream, bag, converted);
    if (converted.scans == 0) {
      throw BagError(converted.damage.empty() ? "the bag holds no scan in the period asked for"
                                              : converted.damage);
    }
  });
  return converted;
}

}  // namespace matchbox_slam
