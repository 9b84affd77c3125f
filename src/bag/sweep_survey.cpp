#include "bag/sweep_survey.hpp"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "bag/queued_message.hpp"

namespace matchbox_slam {
namespace {

constexpr double kLongestSurvey = 600.0;  // [s] of scans; most robots have turned by then
constexpr double kLongestWait = 120.0;    // [s] of scans, for lasers that send little or nothing
constexpr double kLongestPause = 10.0;    // [s] between messages; what is more does not count
constexpr std::size_t kEnoughScans = 10;  // of a laser, to see whether what it sends can be

/// None, too, where the bag is damaged, which whoever maps it is told.
std::optional<BagMessage> next_of(BagStream& stream) {
  try {
    return stream.next();
  } catch (const BagError&) {
    return std::nullopt;
  }
}

/// A queue that nothing is mapped of.
class Survey {
 public:
  Survey(ScanQueueSettings settings, std::size_t lasers)
      : queue_(std::move(settings)), scans_(lasers, 0) {}

  void add(const BagMessage& message) {
    count_seconds(message);
    static_cast<void>(add_message(message, queue_));
    while (const std::optional<ScanQueue::Item> item = queue_.next()) {
      if (const auto* scan = std::get_if<ReadyScan>(&*item)) {
        ++scans_.at(static_cast<std::size_t>(scan->input.laser));
        keep_shown();
      } else if (std::holds_alternative<TimeJump>(*item)) {  // the queue begins anew
        scans_.assign(scans_.size(), 0);
        waited_ = 0.0;
      }
    }
    static_cast<void>(queue_.take_skipped());
    static_cast<void>(queue_.take_news());
  }

  [[nodiscard]] bool is_over() const {
    const bool has_enough =
        waited_ > kLongestWait ||
        std::all_of(scans_.begin(), scans_.end(), [](auto count) { return count >= kEnoughScans; });
    return queue_.stopped() || seconds_ > kLongestSurvey ||
           (has_enough && !queue_.sweep_times().is_any_open());
  }

  [[nodiscard]] const std::map<int, ShownSweep>& shown() const { return shown_; }

 private:
  /// From the first scan on.
  void count_seconds(const BagMessage& message) {
    if (newest_) {
      const double step = std::clamp((message.time - *newest_).toSec(), 0.0, kLongestPause);
      seconds_ += step;
      waited_ += step;
    }
    if (newest_ || std::holds_alternative<ScanMessage>(message.content)) {
      newest_ = message.time;
    }
  }

  /// Where time jumps back, the queue forgets it, and fewer scans tell of it at first.
  void keep_shown() {
    for (const auto& [laser, shown] : queue_.sweep_times().shown()) {
      ShownSweep& kept = shown_[laser];
      if (shown.scans >= kept.scans) {
        kept = shown;
      }
    }
  }

  ScanQueue queue_;
  std::vector<std::size_t> scans_;   ///< of each laser
  std::optional<ros::Time> newest_;  ///< message, since the first scan
  double seconds_ = 0.0;             ///< since the first scan, without pauses
  double waited_ = 0.0;              ///< the same since time jumped back last
  std::map<int, ShownSweep> shown_;
};

}  // namespace

std::map<int, ShownSweep> survey_sweeps(const BagReader& reader, ScanQueueSettings settings,
                                        const std::vector<std::string>& scan_topics,
                                        const std::string& imu_topic, const CloudOptions& cloud,
                                        const std::string& odom_topic,
                                        const std::function<bool()>& is_interrupted) {
  const std::unique_ptr<BagStream> stream =
      reader.stream(scan_topics, {}, imu_topic, cloud, odom_topic);
  Survey survey(std::move(settings), scan_topics.size());
  while (const std::optional<BagMessage> message = next_of(*stream)) {
    survey.add(*message);
    if (survey.is_over() || (is_interrupted && is_interrupted())) {
      break;
    }
  }
  return survey.shown();
}

}  // namespace matchbox_slam
