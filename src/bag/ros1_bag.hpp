#pragma once

#include <map>
#include <memory>
#include <string>

#include "bag/bag_file.hpp"
#include "bag/recording_file.hpp"

namespace matchbox_slam {

/// A bag of ROS 1 as a file of a recording.
class Ros1Bag : public RecordingFile {
 public:
  /// Throws as BagFile does.
  explicit Ros1Bag(const std::string& path) : RecordingFile(path), bag_(path) {}

  [[nodiscard]] const std::map<std::uint32_t, BagConnection>& connections() const override {
    return bag_.connections();
  }
  [[nodiscard]] bool empty() const override { return bag_.empty(); }
  [[nodiscard]] ros::Time begin_time() const override { return bag_.begin_time(); }
  [[nodiscard]] ros::Time end_time() const override { return bag_.end_time(); }
  [[nodiscard]] std::unique_ptr<RecordedMessages> messages(BagSelection selection) const override;

 private:
  BagFile bag_;
};

}  // namespace matchbox_slam
