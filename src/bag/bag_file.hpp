#pragma once

#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bag/bag_records.hpp"
#include "bag/byte_reader.hpp"
#include "bag/recording_file.hpp"

namespace matchbox_slam {

/// A piece of a bag with messages.
struct BagChunk {
  std::uint64_t position = 0;       ///< in the file
  std::uint64_t index = 0;          ///< position of its index's records
  std::uint32_t connections = 0;    ///< that have messages in it, with such a record each
  std::uint32_t unpacked_size = 0;  ///< [bytes]
  ros::Time first;                  ///< at which a message of it was recorded
  ros::Time last;
};

/// Where a message is in a bag.
struct BagEntry {
  ros::Time time;                ///< at which it was recorded
  std::uint32_t connection = 0;  ///< number of its BagConnection
  std::uint32_t offset = 0;      ///< within the unpacked chunk
  std::uint64_t chunk = 0;       ///< position in the file
};

/// A bag file of version 2.0 (wiki.ros.org/Bags/Format/2.0): what is in it, and in which pieces.
/// librosbag believes every length and place that it finds in a file, so that a damaged one makes
/// it read and write beyond its buffers, which no exception tells. Here each is checked first.
class BagFile {
 public:
  using Bytes = std::vector<std::uint8_t>;

  /// Reads the whole index once, and keeps of it what takes no memory for each message.
  /// Throws ConfigurationError for a file that is missing and BagError for one that is empty, cut
  /// off, without index, damaged or no bag.
  explicit BagFile(std::string path);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const std::map<std::uint32_t, BagConnection>& connections() const {
    return connections_;
  }
  /// Those that hold messages, by the times of the first ones; of one time in the order of the
  /// file.
  [[nodiscard]] const std::vector<BagChunk>& chunks() const { return chunks_; }
  [[nodiscard]] bool empty() const { return chunks_.empty(); }
  /// When the first and the last message were recorded, of a bag that is not empty.
  [[nodiscard]] ros::Time begin_time() const { return chunks_.front().first; }
  [[nodiscard]] ros::Time end_time() const { return last_; }

  /// The unpacked data of the chunk at a position in the file. 4 MB are kept, of all bags together:
  /// what a survey has read is read again, and to unpack bz2 takes longer than to map. Throws
  /// ByteError.
  [[nodiscard]] std::shared_ptr<const Bytes> unpacked(std::uint64_t position,
                                                      BagRecordReader& records) const;

 private:
  void read_all(BagRecordReader& records);
  void add_chunk(const BagRecord& info, BagRecordReader& records);

  std::string path_;
  std::map<std::uint32_t, BagConnection> connections_;
  std::vector<BagChunk> chunks_;
  ros::Time last_;
  std::uint64_t number_;  ///< of this one among the process's
};

/// Where messages of a bag are, in the order of time; those of one time in the order of the file.
/// Reads the index of a chunk when it comes to it: a long drive has millions of messages.
class BagEntries {
 public:
  /// @param bag  outlives this.
  BagEntries(const BagFile& bag, BagSelection selection);

  /// The next one; null at the end. Throws BagError when the file is another one by now.
  [[nodiscard]] const BagEntry* peek();
  void pop() { ++next_; }

 private:
  void add(const BagChunk& chunk);

  const BagFile& bag_;
  BagSelection selection_;
  std::size_t next_chunk_;
  std::vector<BagEntry> read_;  ///< from `next_` on they are still to come
  std::size_t next_ = 0;
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
  BagRecordReader records_;
  std::uint64_t position_ = 0;  ///< of `chunk_`; 0: none was read yet
  std::shared_ptr<const BagFile::Bytes> chunk_;
};

}  // namespace matchbox_slam
