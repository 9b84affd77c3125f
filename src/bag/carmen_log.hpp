#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bag/recording_file.hpp"

namespace matchbox_slam {

/// A log of CARMEN, as those of Radish are, packed by gzip or not. Its lasers are on topics of the
/// names of their messages in small letters, such as /flaser, each in a frame of that name, which
/// hangs fixed below base_link; the odometry is odom -> base_link on /tf.
/// What it holds is in memory as a whole: these logs are small.
class CarmenLog : public RecordingFile {
 public:
  /// Throws BagError when it cannot be opened or nothing in it can be read.
  explicit CarmenLog(const std::string& path);

  [[nodiscard]] const std::map<std::uint32_t, BagConnection>& connections() const override {
    return connections_;
  }
  [[nodiscard]] bool empty() const override { return entries_.empty(); }
  [[nodiscard]] ros::Time begin_time() const override { return entries_.front().time; }
  [[nodiscard]] ros::Time end_time() const override { return entries_.back().time; }
  [[nodiscard]] std::vector<std::string> remarks() const override { return remarks_; }
  [[nodiscard]] std::unique_ptr<RecordedMessages> messages(BagSelection selection) const override;

  struct Entry {
    ros::Time time;
    std::uint32_t connection = 0;
    MessageContent content;
  };

 private:
  std::map<std::uint32_t, BagConnection> connections_;
  std::vector<Entry> entries_;  ///< in the order of time
  std::vector<std::string> remarks_;
  std::string damage_;  ///< why the file ends early; empty: it does not
};

}  // namespace matchbox_slam
