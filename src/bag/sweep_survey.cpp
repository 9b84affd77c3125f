#include "bag/sweep_survey.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

namespace matchbox_slam {
namespace {

constexpr double kLongestWait = 120.0;    // [s] for lasers that send too little
constexpr std::size_t kEnoughScans = 10;  // of a laser, to see whether what it sends can be

/// None, too, where the bag is damaged, which whoever maps it is told.
std::optional<BagMessage> next_of(BagStream& stream) {
  try {
    return stream.next();
  } catch (const BagError&) {
    return std::nullopt;
  }
}

}  // namespace

std::string add_message(const BagMessage& message, ScanQueue& queue) {
  if (const auto* transforms = std::get_if<BagTransforms>(&message.content)) {
    queue.add_transforms(*transforms->message, transforms->is_static, message.time);
    return {};
  }
  if (const auto* imu = std::get_if<sensor_msgs::Imu::ConstPtr>(&message.content)) {
    return queue.add_imu(**imu, message.time);
  }
  if (const auto* odometry = std::get_if<nav_msgs::Odometry::ConstPtr>(&message.content)) {
    return queue.add_odometry(**odometry, message.time);
  }
  queue.add_scan(std::get<ScanMessage>(message.content), message.time, message.laser);
  return {};
}

std::map<int, ShownSweep> survey_sweeps(const BagReader& reader, ScanQueueSettings settings,
                                        const std::vector<std::string>& scan_topics,
                                        const std::string& imu_topic, const CloudOptions& cloud,
                                        const std::string& odom_topic,
                                        const std::function<bool()>& is_interrupted) {
  const std::unique_ptr<BagStream> stream =
      reader.stream(scan_topics, {}, imu_topic, cloud, odom_topic);
  settings.max_lag = 0.0;
  ScanQueue queue(std::move(settings));
  std::vector<std::size_t> scans(scan_topics.size(), 0);
  std::optional<ros::Time> begin;
  while (const std::optional<BagMessage> message = next_of(*stream)) {
    begin = begin ? begin : message->time;
    static_cast<void>(add_message(*message, queue));
    while (const std::optional<ScanQueue::Item> item = queue.next()) {
      if (const auto* scan = std::get_if<ReadyScan>(&*item)) {
        ++scans.at(static_cast<std::size_t>(scan->input.laser));
      }
    }
    const bool has_waited = (message->time - *begin).toSec() > kLongestWait;
    const bool has_enough = has_waited || std::all_of(scans.begin(), scans.end(), [](auto count) {
                              return count >= kEnoughScans;
                            });
    if ((has_enough && !queue.sweep_times().is_any_open()) ||
        (is_interrupted && is_interrupted())) {
      break;
    }
  }
  return queue.sweep_times().shown();
}

}  // namespace matchbox_slam
