#include "bag/bag_reader.hpp"

#include <fmt/core.h>
#include <ros/message_traits.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "bag/merged_messages.hpp"
#include "bag/open_recording.hpp"
#include "matchbox_slam/common/options.hpp"
#include "ros/message_conversion.hpp"
#include "run/run_dialog.hpp"

namespace matchbox_slam {

bool is_transform_topic(const std::string& topic) { return topic == "/tf" || topic == "tf"; }
bool is_static_transform_topic(const std::string& topic) {
  return topic == "/tf_static" || topic == "tf_static";
}

namespace {

/// What a message holds, which must be of this type.
template <typename Message>
const boost::shared_ptr<const Message>& content_of(const RecordedMessage& message) {
  const auto* content = std::get_if<boost::shared_ptr<const Message>>(&message.content);
  if (content == nullptr) {
    throw BagError(fmt::format("topic {} of the bag holds {}, not {}", message.connection->topic,
                               message.connection->type, ros::message_traits::datatype<Message>()));
  }
  return *content;
}

ScanMessage read_scan(const RecordedMessage& message, const CloudOptions& cloud) {
  if (const auto* echoes =
          std::get_if<sensor_msgs::MultiEchoLaserScan::ConstPtr>(&message.content)) {
    return to_scan(**echoes);
  }
  if (const auto* points = std::get_if<sensor_msgs::PointCloud2::ConstPtr>(&message.content)) {
    return to_scan(**points, cloud);
  }
  return to_scan(content_of<sensor_msgs::LaserScan>(message));
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

/// What is asked of bags: what was said on /tf_static before a period, or the period.
std::vector<FileSelection> selections_of(
    const std::vector<std::unique_ptr<RecordingFile>>& bags, const BagSelection& times,
    const std::function<bool(const BagConnection&)>& is_asked) {
  std::vector<FileSelection> selections;
  for (const auto& bag : bags) {
    BagSelection selection = times;
    for (const auto& [number, connection] : bag->connections()) {
      if (is_asked(connection)) {
        selection.connections.insert(number);
      }
    }
    selections.push_back({bag.get(), std::move(selection)});
  }
  return selections;
}

/// What was said on /tf_static before a period, and then the period.
class PeriodStream : public MessageStream {
 public:
  PeriodStream(const std::vector<std::unique_ptr<RecordingFile>>& bags, const ros::Time& first,
               const ros::Time& last, const std::function<bool(const BagConnection&)>& is_asked)
      : before_(selections_of(
            bags, {{}, ros::Time(), first.isZero() ? first : first - ros::Duration(0, 1)},
            [&](const BagConnection& connection) {
              return is_static_transform_topic(connection.topic) && !first.isZero();
            })),
        during_(selections_of(bags, {{}, first, last}, is_asked)) {}

  std::optional<RecordedMessage> next() override {
    if (is_over_) {
      return std::nullopt;
    }
    is_over_ = true;  // should this fail
    try {
      std::optional<RecordedMessage> message = before_.next();
      if (!message) {
        message = during_.next();
      }
      if (message) {
        is_over_ = false;
        last_read_ = message->time;
      }
      return message;
    } catch (const BagError&) {
      throw;
    } catch (const std::exception& error) {
      const std::string place =
          last_read_ ? fmt::format("{:f} s", last_read_->toSec()) : "its beginning";
      throw BagError(fmt::format("the bag is damaged after {} ({})", place, error.what()));
    }
  }

 private:
  MergedMessages before_;
  MergedMessages during_;
  bool is_over_ = false;
  std::optional<ros::Time> last_read_;
};

/// Reads messages as what they are for.
class ScanStream : public BagStream {
 public:
  ScanStream(std::unique_ptr<MessageStream> messages, BagAsked asked)
      : messages_(std::move(messages)), asked_(std::move(asked)) {}

  std::optional<BagMessage> next() override {
    const std::optional<RecordedMessage> recorded = messages_->next();
    return recorded ? std::optional(read(*recorded)) : std::nullopt;
  }

 private:
  [[nodiscard]] BagMessage read(const RecordedMessage& recorded) const {
    const std::string& topic = recorded.connection->topic;
    BagMessage message;
    message.time = recorded.time;
    if (is_transform_topic(topic) || is_static_transform_topic(topic)) {
      message.content = BagTransforms{content_of<tf2_msgs::TFMessage>(recorded),
                                      is_static_transform_topic(topic)};
    } else if (topic == asked_.imu_topic) {
      message.content = content_of<sensor_msgs::Imu>(recorded);
    } else if (topic == asked_.odom_topic) {
      message.content = content_of<nav_msgs::Odometry>(recorded);
    } else {
      const std::vector<std::string>& topics = asked_.scan_topics;
      message.content = read_scan(recorded, asked_.cloud);
      message.laser =
          static_cast<int>(std::find(topics.begin(), topics.end(), topic) - topics.begin());
    }
    return message;
  }

  const std::unique_ptr<MessageStream> messages_;
  const BagAsked asked_;
};

ros::Time seconds_after(const ros::Time& begin, double seconds) {
  const double latest = ros::TIME_MAX.toSec() - 1.0;
  const double longest = ros::DURATION_MAX.toSec() - 1.0;
  return seconds < longest && begin.toSec() + seconds < latest ? begin + ros::Duration(seconds)
                                                               : ros::TIME_MAX;
}

std::vector<const RecordingFile*> files_with(
    const std::string& topic, const std::vector<std::unique_ptr<RecordingFile>>& files) {
  std::vector<const RecordingFile*> with;
  for (const auto& file : files) {
    const auto& connections = file->connections();
    if (std::any_of(connections.begin(), connections.end(), [&topic](const auto& connection) {
          return connection.second.topic == topic && connection.second.messages > 0;
        })) {
      with.push_back(file.get());
    }
  }
  return with;
}

}  // namespace

BagReader::BagReader(const std::vector<std::string>& paths) {
  std::map<std::string, BagTopic> topics;
  std::set<std::string> seen;
  for (const std::string& path : paths) {
    if (!seen.insert(path).second) {
      throw ConfigurationError(fmt::format("bag '{}' is named twice", path));
    }
    OpenRecording opened = open_recording(path);
    std::move(opened.files.begin(), opened.files.end(), std::back_inserter(bags_));
    std::move(opened.remarks.begin(), opened.remarks.end(), std::back_inserter(remarks_));
  }
  for (const auto& bag : bags_) {
    if (bag->empty()) {
      throw BagError(fmt::format("bag '{}' holds no messages", bag->path()));
    }
    for (const auto& [number, connection] : bag->connections()) {
      topics[connection.topic].name = connection.topic;
      topics[connection.topic].type = connection.type;
      topics[connection.topic].messages += connection.messages;
    }
    begins_.push_back(bag->begin_time());
    end_ = std::max(end_, bag->end_time());
  }
  begin_ = *std::min_element(begins_.begin(), begins_.end());
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

std::string BagReader::text_of_overlap(const std::vector<std::string>& scan_topics) const {
  constexpr double kMinOverlap = 1.0;  // [s]: files of a drive that is split meet by less
  std::string names;
  double longest = 0.0;
  std::size_t pairs = 0;
  for (const std::string& topic : scan_topics) {
    const std::vector<const RecordingFile*> files = files_with(topic, bags_);
    for (auto a = files.begin(); a != files.end(); ++a) {
      for (auto b = a + 1; b != files.end(); ++b) {
        const double both = seconds_between(std::max((*a)->begin_time(), (*b)->begin_time()),
                                            std::min((*a)->end_time(), (*b)->end_time()));
        pairs += both > kMinOverlap ? 1 : 0;
        if (both > std::max(longest, kMinOverlap)) {
          longest = both;
          names = fmt::format("{} and {} both hold scans of {}", (*a)->path(), (*b)->path(), topic);
        }
      }
    }
  }
  if (pairs == 0) {
    return "";
  }
  return fmt::format(
      "{}, and are of the same time for {}{}: they are read as one recording, mixed by time. Of "
      "two drives or robots map each by itself, then join the maps: merge_maps A/map.slam "
      "B/map.slam --out DIR; of two recordings of one drive give one alone",
      names, seconds_text(longest),
      pairs > 1 ? fmt::format(", and so {} pairs of files in all", pairs) : "");
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
  BagAsked asked{scan_topics, imu_topic, cloud, odom_topic};
  const auto is_asked = [&asked](const BagConnection& connection) {
    return asked.has(connection.topic);
  };
  std::unique_ptr<MessageStream> asked_messages = messages(is_asked, period);
  return std::make_unique<ScanStream>(std::move(asked_messages), std::move(asked));
}

std::unique_ptr<MessageStream> BagReader::messages(
    const std::function<bool(const BagConnection&)>& is_asked, const BagPeriod& period) const {
  const ros::Time first = seconds_after(begin_, period.start);
  const ros::Time last = seconds_after(first, period.duration);
  return std::make_unique<PeriodStream>(bags_, first, last, is_asked);
}

std::vector<std::string> BagReader::remarks() const {
  std::vector<std::string> all = remarks_;
  for (const auto& bag : bags_) {
    for (std::string& remark : bag->remarks()) {
      all.push_back(std::move(remark));
    }
  }
  return all;
}

}  // namespace matchbox_slam
