#pragma once

#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "bag/byte_reader.hpp"

namespace matchbox_slam {

/// Thrown when a bag cannot be read. The text names the bag, what is wrong and what to do.
class BagError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One recorder's messages on one topic.
struct BagConnection {
  std::string topic;
  std::string type;  ///< such as "sensor_msgs/LaserScan"
  std::string md5sum;
};

/// Where a message is in a bag.
struct BagEntry {
  ros::Time time;                ///< at which it was recorded
  std::uint32_t connection = 0;  ///< number of its BagConnection
  std::uint32_t offset = 0;      ///< within the unpacked chunk
  std::uint64_t chunk = 0;       ///< position in the file
};

/// The index of a bag file of version 2.0 (wiki.ros.org/Bags/Format/2.0).
/// librosbag believes every length and place that it finds in a file, so that a damaged one makes
/// it read and write beyond its buffers, which no exception tells. Here each is checked first.
class BagFile {
 public:
  /// Throws ConfigurationError for a file that is missing and BagError for one that is empty, cut
  /// off, without index, damaged or no bag.
  explicit BagFile(std::string path);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const std::map<std::uint32_t, BagConnection>& connections() const {
    return connections_;
  }
  /// In the order of time; those of one time in the order of the file.
  [[nodiscard]] const std::vector<BagEntry>& entries() const { return entries_; }

 private:
  std::string path_;
  std::map<std::uint32_t, BagConnection> connections_;
  std::vector<BagEntry> entries_;
};

/// Reads messages of a bag. Keeps the chunk that it read last: messages near each other in time are
/// near each other in the file.
class BagMessageReader {
 public:
  /// @param file  outlives this.
  explicit BagMessageReader(const BagFile& file);

  /// The message as it was sent; good until the next call.
  /// Throws BagError naming the byte at which the file is damaged.
  [[nodiscard]] ByteReader read(const BagEntry& entry);

 private:
  void load_chunk(std::uint64_t position);

  const BagFile& bag_;
  std::ifstream stream_;
  std::uint64_t size_;
  std::uint64_t position_ = 0;       ///< of `chunk_`; 0: none was read yet
  std::vector<std::uint8_t> chunk_;  ///< unpacked
};

}  // namespace matchbox_slam
