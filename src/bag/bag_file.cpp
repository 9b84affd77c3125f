#include "bag/bag_file.hpp"

#include <fmt/core.h>
#include <rosbag/chunked_file.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <tuple>
#include <utility>

#include "common/lru_cache.hpp"
#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kVersionLine = 13;  // bytes, "#ROSBAG V2.0" and the end of its line

// No recorder comes near it; a size beyond is damage, not worth trying to get the memory.
constexpr std::uint32_t kLargestChunk = 1U << 30U;

std::string repair(const std::string& path) {
  return fmt::format(
      "; `rosbag reindex {}` makes it readable, but only up to the first damage: what is behind "
      "that is lost to it, and stays in the .orig.bag that it leaves beside",
      path);
}

[[noreturn]] void throw_damaged(const std::string& path, std::uint64_t position,
                                const std::string& what) {
  throw BagError(
      fmt::format("bag '{}' is damaged at byte {} ({}){}", path, position, what, repair(path)));
}

void require_readable_file(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) {
    throw ConfigurationError(fmt::format("bag '{}' does not exist", path));
  }
  if (fs::is_directory(status)) {
    throw ConfigurationError(
        fmt::format("'{}' is a folder without a recording: it holds no metadata.yaml, .db3 or "
                    ".mcap of ROS 2; of ROS 1 and CARMEN give the files themselves",
                    path));
  }
  if (fs::is_regular_file(status) && fs::file_size(path, error) == 0) {
    throw BagError(fmt::format("bag '{}' is empty (0 bytes)", path));
  }
  const std::string version = "#ROSBAG V2.0";
  std::string beginning(version.size(), ' ');
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw BagError(fmt::format("bag '{}' cannot be read: is it allowed?", path));
  }
  if (!file.read(beginning.data(), static_cast<std::streamsize>(beginning.size())) ||
      beginning != version) {
    throw BagError(fmt::format(
        "'{}' is no bag of version 2.0; it begins with other bytes than '{}'", path, version));
  }
}

/// Calls `visit` with each entry of those of a chunk's index records whose connection is asked for,
/// which is known then.
template <typename IsAsked, typename Visit>
void read_index(const BagChunk& chunk, BagRecordReader& records, const IsAsked& is_asked,
                const Visit& visit) {
  std::uint64_t next = chunk.index;
  for (std::uint32_t i = 0; i < chunk.connections; ++i) {
    const BagRecord index = records.read(next, BagOperation::kIndex);
    next = index.end();
    BagEntry entry;
    entry.chunk = chunk.position;
    entry.connection = index.fields.number<std::uint32_t>("conn");
    if (!is_asked(entry.connection)) {
      continue;
    }
    const std::vector<std::uint8_t> data = records.data_of(index);
    ByteReader bytes(data.data(), data.size());
    for (auto left = index.fields.number<std::uint32_t>("count"); left > 0; --left) {
      entry.time.sec = bytes.number<std::uint32_t>();
      entry.time.nsec = bytes.number<std::uint32_t>();
      entry.offset = bytes.number<std::uint32_t>();
      if (entry.time.nsec >= 1'000'000'000U || entry.offset >= chunk.unpacked_size) {
        throw ByteError("an entry of an index points nowhere");
      }
      visit(entry);
    }
  }
}

/// What was unpacked last, by the number of the bag and the position in it. Ten seconds of a laser
/// and its odometry are some megabytes. Not for each bag: a drive may be split into hundreds.
LruCache<BagFile::Bytes>& unpacked_chunks() {
  static LruCache<BagFile::Bytes> chunks(4 << 20,
                                         [](const BagFile::Bytes& bytes) { return bytes.size(); });
  return chunks;
}

std::uint64_t next_bag_number() {
  static std::atomic<std::uint64_t> next{0};
  return next++;
}

/// Unpacks a chunk's data to so many bytes.
std::vector<std::uint8_t> unpack(std::vector<std::uint8_t> packed, const std::string& compression,
                                 std::uint32_t size) {
  if (compression == "none") {
    if (packed.size() != size) {
      throw ByteError(fmt::format("a chunk of {} bytes has {}", size, packed.size()));
    }
    return packed;
  }
  if (compression != "bz2" && compression != "lz4") {
    throw ByteError("a chunk's compression is neither none, bz2 nor lz4");
  }
  if (size > kLargestChunk) {
    throw ByteError(fmt::format("a chunk is said to unpack to {} bytes", size));
  }
  std::vector<std::uint8_t> unpacked(size);
  try {
    rosbag::ChunkedFile().decompress(
        compression == "bz2" ? rosbag::compression::BZ2 : rosbag::compression::LZ4, unpacked.data(),
        size, packed.data(), static_cast<unsigned>(packed.size()));
  } catch (const std::exception& error) {
    throw ByteError(std::string("a chunk cannot be unpacked: ") + error.what());
  }
  return unpacked;
}

/// The data of the message at the beginning of `bytes`. Connections may be recorded before it.
ByteReader find_message(ByteReader bytes, std::uint32_t connection) {
  while (true) {
    const BagFields fields(bytes.array());
    const ByteReader data = bytes.array();
    if (fields.operation() != BagOperation::kConnection) {
      fields.require(BagOperation::kMessage);
      if (fields.number<std::uint32_t>("conn") != connection) {
        throw ByteError("a message is not of the connection that the index says");
      }
      return data;
    }
  }
}

bool is_before(const BagEntry& a, const BagEntry& b) {
  return std::tie(a.time, a.chunk, a.offset) < std::tie(b.time, b.chunk, b.offset);
}

}  // namespace

BagFile::BagFile(std::string path) : path_(std::move(path)), number_(next_bag_number()) {
  require_readable_file(path_);
  BagRecordReader records(path_);
  try {
    read_all(records);
  } catch (const ByteError& error) {
    throw_damaged(path_, records.position(), error.what());
  }
  std::stable_sort(chunks_.begin(), chunks_.end(),
                   [](const BagChunk& a, const BagChunk& b) { return a.first < b.first; });
}

void BagFile::read_all(BagRecordReader& records) {
  const BagRecord header = records.read(kVersionLine, BagOperation::kBagHeader);
  auto next = header.fields.number<std::uint64_t>("index_pos");
  if (next == 0) {
    throw BagError(fmt::format("bag '{}' has no index, as its recording did not end properly{}",
                               path_, repair(path_)));
  }
  const auto connection_count = header.fields.number<std::uint32_t>("conn_count");
  const auto chunk_count = header.fields.number<std::uint32_t>("chunk_count");
  for (std::uint32_t i = 0; i < connection_count; ++i) {
    const BagRecord record = records.read(next, BagOperation::kConnection);
    next = record.end();
    const std::vector<std::uint8_t> data = records.data_of(record);
    const BagFields sent(ByteReader(data.data(), data.size()));
    connections_[record.fields.number<std::uint32_t>("conn")] = {
        record.fields.text("topic"), sent.text("type"), sent.text("md5sum")};
  }
  for (std::uint32_t i = 0; i < chunk_count; ++i) {
    const BagRecord info = records.read(next, BagOperation::kChunkInfo);
    next = info.end();
    add_chunk(info, records);
  }
}

void BagFile::add_chunk(const BagRecord& info, BagRecordReader& records) {
  BagChunk chunk;
  chunk.position = info.fields.number<std::uint64_t>("chunk_pos");
  chunk.connections = info.fields.number<std::uint32_t>("count");
  const BagRecord record = records.read(chunk.position, BagOperation::kChunk);
  chunk.unpacked_size = record.fields.number<std::uint32_t>("size");
  chunk.index = record.end();
  const auto require_known = [this](std::uint32_t connection) {
    if (connections_.count(connection) == 0) {
      throw ByteError(fmt::format("connection {} is not known", connection));
    }
    return true;
  };
  bool is_empty = true;
  read_index(chunk, records, require_known, [&](const BagEntry& entry) {
    chunk.first = is_empty ? entry.time : std::min(chunk.first, entry.time);
    chunk.last = is_empty ? entry.time : std::max(chunk.last, entry.time);
    is_empty = false;
    ++connections_[entry.connection].messages;
  });
  if (!is_empty) {
    last_ = std::max(last_, chunk.last);
    chunks_.push_back(chunk);
  }
}

std::shared_ptr<const BagFile::Bytes> BagFile::unpacked(std::uint64_t position,
                                                        BagRecordReader& records) const {
  constexpr int kPositionBits = 40;  // of a file's bytes, of which it has read each chunk's first
  return unpacked_chunks().get(number_ << kPositionBits | position, [&] {
    const BagRecord record = records.read(position, BagOperation::kChunk);
    return unpack(records.data_of(record), record.fields.text("compression"),
                  record.fields.number<std::uint32_t>("size"));
  });
}

BagEntries::BagEntries(const BagFile& bag, BagSelection selection)
    : bag_(bag),
      selection_(std::move(selection)),
      next_chunk_(selection_.connections.empty() ? bag.chunks().size() : 0) {}

const BagEntry* BagEntries::peek() {
  const std::vector<BagChunk>& chunks = bag_.chunks();
  while (next_chunk_ < chunks.size() && chunks[next_chunk_].first <= selection_.last &&
         (next_ == read_.size() || chunks[next_chunk_].first <= read_[next_].time)) {
    const BagChunk& chunk = chunks[next_chunk_++];
    if (chunk.last >= selection_.first) {
      add(chunk);
    }
  }
  return next_ == read_.size() ? nullptr : &read_[next_];
}

/// Puts a chunk's entries among those that are still to come.
void BagEntries::add(const BagChunk& chunk) {
  read_.erase(read_.begin(), read_.begin() + static_cast<std::ptrdiff_t>(next_));
  next_ = 0;
  const auto old = static_cast<std::ptrdiff_t>(read_.size());
  const auto is_asked = [this](std::uint32_t connection) {
    return selection_.connections.count(connection) > 0;
  };
  BagRecordReader records(bag_.path());  // opened anew, as a drive may be split into many bags
  try {
    read_index(chunk, records, is_asked, [this](const BagEntry& entry) {
      if (entry.time >= selection_.first && entry.time <= selection_.last) {
        read_.push_back(entry);
      }
    });
  } catch (const ByteError& error) {  // it has been written to since
    throw_damaged(bag_.path(), records.position(), error.what());
  }
  std::sort(read_.begin() + old, read_.end(), is_before);
  std::inplace_merge(read_.begin(), read_.begin() + old, read_.end(), is_before);
}

BagMessageReader::BagMessageReader(const BagFile& file) : bag_(file), records_(file.path()) {}

ByteReader BagMessageReader::read(const BagEntry& entry) {
  try {
    if (entry.chunk != position_) {
      load_chunk(entry.chunk);
    }
    ByteReader chunk(chunk_->data(), chunk_->size());
    (void)chunk.take(entry.offset);
    return find_message(chunk, entry.connection);
  } catch (const ByteError& error) {
    throw_damaged(bag_.path(), entry.chunk, error.what());
  }
}

void BagMessageReader::load_chunk(std::uint64_t position) {
  position_ = 0;  // none, should this fail
  chunk_ = bag_.unpacked(position, records_);
  position_ = position;
}

}  // namespace matchbox_slam
