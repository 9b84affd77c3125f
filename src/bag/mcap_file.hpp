#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bag/byte_reader.hpp"
#include "bag/recording_file.hpp"

namespace matchbox_slam {

/// A piece of a file with messages.
struct McapChunk {
  std::uint64_t position = 0;       ///< of its records in the file
  std::uint64_t size = 0;           ///< of them there [bytes]
  std::string compression;          ///< empty: none
  std::uint64_t unpacked_size = 0;  ///< [bytes]
  std::uint32_t checksum = 0;       ///< of the unpacked records; 0: not told
  std::uint64_t first = 0;          ///< [ns] when a message of it was recorded
  std::uint64_t last = 0;
  bool is_cut = false;  ///< the file ends within it
};

/// An MCAP file (mcap.dev/spec) with messages as ROS 2 or ROS 1 sends them. It is read from the
/// front, so that the summary at its end is not needed: a file that is cut off is read as far as it
/// goes.
class McapFile : public RecordingFile {
 public:
  /// Throws BagError where nothing in it can be read.
  explicit McapFile(const std::string& path);

  [[nodiscard]] const std::map<std::uint32_t, BagConnection>& connections() const override {
    return connections_;
  }
  [[nodiscard]] bool empty() const override { return chunks_.empty(); }
  [[nodiscard]] ros::Time begin_time() const override;
  [[nodiscard]] ros::Time end_time() const override;
  [[nodiscard]] std::unique_ptr<RecordedMessages> messages(BagSelection selection) const override;

  /// By the times of their first messages.
  [[nodiscard]] const std::vector<McapChunk>& chunks() const { return chunks_; }
  [[nodiscard]] const std::string& encoding_of(std::uint32_t channel) const {
    return encodings_.at(channel);
  }
  /// Why there is no more to read; empty: the file is whole.
  [[nodiscard]] const std::string& damage() const { return damage_; }

 private:
  class Scanner;

  std::map<std::uint32_t, BagConnection> connections_;  ///< by the number of their channel
  std::map<std::uint32_t, std::string> encodings_;      ///< of their messages
  std::vector<McapChunk> chunks_;
  std::uint64_t last_ = 0;  ///< [ns]
  std::string damage_;
};

}  // namespace matchbox_slam
