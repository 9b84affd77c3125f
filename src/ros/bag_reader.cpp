#include "matchbox_slam/ros/bag_reader.hpp"

#include <rosbag/view.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {

namespace {

namespace fs = std::filesystem;

bool is_transform_topic(const std::string& topic) { return topic == "/tf" || topic == "tf"; }
bool is_static_transform_topic(const std::string& topic) {
  return topic == "/tf_static" || topic == "tf_static";
}

void require_readable_file(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) {
    throw ConfigurationError("bag '" + path + "' does not exist");
  }
  if (fs::is_directory(status)) {
    throw ConfigurationError("bag '" + path + "' is a folder, not a bag file");
  }
  if (fs::is_regular_file(status) && fs::file_size(path, error) == 0) {
    throw BagError("bag '" + path + "' is empty (0 bytes)");
  }
  const std::string version = "#ROSBAG V2.0";
  std::string beginning(version.size(), ' ');
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw BagError("bag '" + path + "' may not be read");
  }
  if (!file.read(beginning.data(), static_cast<std::streamsize>(beginning.size())) ||
      beginning != version) {
    throw BagError("'" + path + "' is no bag of version 2.0; it begins with other bytes than '" +
                   version + "'");
  }
}

std::unique_ptr<rosbag::Bag> open_bag(const std::string& path) {
  require_readable_file(path);
  const std::string repair = "; run `rosbag reindex " + path + "` and try again";
  try {
    return std::make_unique<rosbag::Bag>(path, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw BagError("bag '" + path + "' has no index, as its recording did not end properly" +
                   repair);
  } catch (const rosbag::BagIOException& error) {
    throw BagError("bag '" + path + "' cannot be read to its end (" + error.what() +
                   "), it may be cut off" + repair);
  } catch (const std::exception& error) {
    throw BagError("bag '" + path + "' is damaged (" + error.what() + ")" + repair);
  }
}

/// Follows a rosbag::View and turns its messages into ours.
class ViewStream : public BagStream {
 public:
  /// @param before  what was recorded on /tf_static before the period.
  ViewStream(std::unique_ptr<rosbag::View> before, std::unique_ptr<rosbag::View> period,
             std::vector<std::string> scan_topics)
      : views_{std::move(before), std::move(period)}, scan_topics_(std::move(scan_topics)) {}

  std::optional<BagMessage> next() override {
    try {
      for (; view_ < views_.size(); ++view_, position_.reset()) {
        if (!position_) {
          position_ = views_[view_]->begin();
        } else if (*position_ != views_[view_]->end()) {
          ++*position_;
        }
        if (*position_ != views_[view_]->end()) {
          return convert(**position_);
        }
      }
      return std::nullopt;
    } catch (const BagError&) {
      throw;
    } catch (const std::exception& error) {
      throw BagError("the bag is damaged after " + last_read_ + " (" + error.what() + ")");
    }
  }

 private:
  BagMessage convert(const rosbag::MessageInstance& instance) {
    const std::string& topic = instance.getTopic();
    BagMessage message;
    message.time = instance.getTime();
    last_read_ = std::to_string(message.time.toSec()) + " s";
    if (is_transform_topic(topic) || is_static_transform_topic(topic)) {
      message.content = BagTransforms{instantiate<tf2_msgs::TFMessage>(instance),
                                      is_static_transform_topic(topic)};
    } else {
      message.content =
          sensor_msgs::LaserScan::ConstPtr(instantiate<sensor_msgs::LaserScan>(instance));
      message.laser = static_cast<int>(std::find(scan_topics_.begin(), scan_topics_.end(), topic) -
                                       scan_topics_.begin());
    }
    return message;
  }

  template <typename Message>
  static boost::shared_ptr<Message> instantiate(const rosbag::MessageInstance& instance) {
    boost::shared_ptr<Message> message = instance.instantiate<Message>();
    if (message == nullptr) {
      throw BagError("topic " + instance.getTopic() + " of the bag holds " +
                     instance.getDataType() + " in a definition that is not the one of " +
                     ros::message_traits::datatype<Message>());
    }
    return message;
  }

  std::array<std::unique_ptr<rosbag::View>, 2> views_;
  std::vector<std::string> scan_topics_;
  std::size_t view_ = 0;
  std::optional<rosbag::View::iterator> position_;
  std::string last_read_ = "its beginning";
};

ros::Time seconds_after(const ros::Time& begin, double seconds) {
  const double latest = ros::TIME_MAX.toSec() - 1.0;
  const double stamp = begin.toSec() + seconds;
  return stamp < latest ? begin + ros::Duration(seconds) : ros::TIME_MAX;
}

}  // namespace

BagReader::BagReader(const std::vector<std::string>& paths) : paths_(paths) {
  std::map<std::string, BagTopic> topics;
  std::set<std::string> seen;
  for (const std::string& path : paths) {
    if (!seen.insert(path).second) {
      throw ConfigurationError("bag '" + path + "' is named twice");
    }
    bags_.push_back(open_bag(path));
    rosbag::View view(*bags_.back());
    for (const rosbag::ConnectionInfo* connection : view.getConnections()) {
      BagTopic& topic = topics[connection->topic];
      topic.name = connection->topic;
      topic.type = connection->datatype;
    }
    if (view.size() == 0) {
      throw BagError("bag '" + path + "' holds no messages");
    }
    begin_ = bags_.size() == 1 ? view.getBeginTime() : std::min(begin_, view.getBeginTime());
    end_ = std::max(end_, view.getEndTime());
  }
  for (auto& [name, topic] : topics) {
    rosbag::View view;
    for (const auto& bag : bags_) {
      view.addQuery(*bag, rosbag::TopicQuery(name));
    }
    topic.messages = view.size();
    topics_.push_back(topic);
  }
}

BagReader::~BagReader() = default;

std::vector<std::string> BagReader::scan_topics() const {
  std::vector<std::string> names;
  for (const BagTopic& topic : topics_) {
    if (topic.type == "sensor_msgs/LaserScan") {
      names.push_back(topic.name);
    }
  }
  return names;
}

std::unique_ptr<BagStream> BagReader::stream(const std::vector<std::string>& scan_topics,
                                             const BagPeriod& period) const {
  std::vector<std::string> topics = {"/tf", "tf", "/tf_static", "tf_static"};
  topics.insert(topics.end(), scan_topics.begin(), scan_topics.end());
  const ros::Time first = seconds_after(begin_, period.start);
  const ros::Time last = seconds_after(first, period.duration);
  auto before = std::make_unique<rosbag::View>();
  auto during = std::make_unique<rosbag::View>();
  for (const auto& bag : bags_) {
    if (first > begin_) {
      before->addQuery(*bag,
                       rosbag::TopicQuery(std::vector<std::string>{"/tf_static", "tf_static"}),
                       begin_, first - ros::Duration(0, 1));
    }
    during->addQuery(*bag, rosbag::TopicQuery(topics), first, last);
  }
  return std::make_unique<ViewStream>(std::move(before), std::move(during), scan_topics);
}

}  // namespace matchbox_slam
