#pragma once

#include <rosbag/bag.h>

#include <functional>
#include <memory>
#include <string>

namespace matchbox_slam {

/// Writes a bag of ROS 1 beside its place until it is complete.
class BagWriter {
 public:
  /// Opens the bag, so that a path that cannot be written shows before the work starts.
  /// Throws FileError.
  BagWriter(std::string path, rosbag::CompressionType compression);
  /// Closes and removes a bag that was not finished.
  ~BagWriter();
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  /// Writes all that `write_messages` gives to the bag and puts it in its place; to be called once.
  /// What that throws passes through, but for a failure to write, which becomes a FileError.
  void write(const std::function<void(rosbag::Bag&)>& write_messages);

 private:
  void throw_away();

  std::string path_;
  std::string unfinished_path_;
  std::unique_ptr<rosbag::Bag> bag_ = std::make_unique<rosbag::Bag>();
};

}  // namespace matchbox_slam
