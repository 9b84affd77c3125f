#include "bag/mcap_file.hpp"

#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <tuple>

#include "bag/bag_error.hpp"
#include "bag/cdr_message.hpp"
#include "bag/mcap_records.hpp"
#include "bag/ros1_message.hpp"
#include "bag/unpacking.hpp"

namespace matchbox_slam {
namespace {

constexpr std::uint64_t kMagicSize = 8;
constexpr std::uint64_t kSecond = 1'000'000'000U;  // [ns]
constexpr std::uint64_t kLatest = 4'294'967'295U * kSecond;

// No recorder comes near it; a size beyond is damage, not worth trying to get the memory.
constexpr std::uint64_t kLargestChunk = 1U << 30U;

ros::Time to_time(std::uint64_t nanoseconds) { return ros::Time().fromNSec(nanoseconds); }

void require_time(std::uint64_t nanoseconds) {
  if (nanoseconds > kLatest) {
    throw ByteError("a message is said to be of after 2106");
  }
}

std::string text_of_damage(const std::string& path, std::uint64_t position,
                           const std::string& what) {
  return fmt::format(
      "bag '{}' is damaged at byte {} ({}); `mcap recover '{}' -o NEW.mcap` may save more", path,
      position, what, path);
}

std::uint32_t checksum_of(const Bytes& bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, bytes.data(), bytes.size()));
}

/// A chunk's records. Throws ByteError where they are damaged, but for being cut off.
Bytes records_of(const McapChunk& chunk, McapRecordReader& file) {
  if (chunk.unpacked_size > kLargestChunk) {
    throw ByteError(fmt::format("a chunk is said to unpack to {} bytes", chunk.unpacked_size));
  }
  Bytes packed = file.bytes(chunk.position, chunk.size);
  Unpacked unpacked;
  if (chunk.compression.empty()) {
    unpacked.bytes = std::move(packed);
  } else {
    const ByteReader bytes(packed.data(), packed.size());
    unpacked = chunk.compression == "zstd" ? unpack_zstd(bytes, chunk.unpacked_size)
                                           : unpack_lz4(bytes, chunk.unpacked_size);
  }
  if (chunk.is_cut) {
    return std::move(unpacked.bytes);
  }
  if (!unpacked.defect.empty()) {
    throw ByteError("a chunk cannot be unpacked: " + unpacked.defect);
  }
  if (unpacked.bytes.size() != chunk.unpacked_size) {
    throw ByteError(
        fmt::format("a chunk of {} bytes has {}", chunk.unpacked_size, unpacked.bytes.size()));
  }
  if (chunk.checksum != 0 && chunk.checksum != checksum_of(unpacked.bytes)) {
    throw ByteError("a chunk's checksum is not that of its records");
  }
  return std::move(unpacked.bytes);
}

}  // namespace

/// Goes through a file from its front.
class McapFile::Scanner {
 public:
  explicit Scanner(McapFile& file) : file_(file), reader_(file.path()) {}

  void scan();

 private:
  bool take(const McapRecord& record);
  void take_chunk(const McapRecord& record);
  void take_message(const McapRecord& record);
  void add_chunk(const McapChunk& chunk);
  void take_index(const McapRecord& record);
  void look_into_chunk();
  void finish_chunk();
  void finish_last_chunk();
  void register_record(McapOperation operation, const ByteReader& content);
  void count(std::uint32_t channel, std::size_t messages);

  McapFile& file_;
  McapRecordReader reader_;
  std::map<std::uint32_t, std::string> schemas_;
  /// A chunk whose index may follow.
  std::optional<McapChunk> chunk_;
  std::map<std::uint32_t, std::size_t> indexed_;  ///< messages of it by their channel
};

void McapFile::Scanner::scan() {
  std::uint64_t position = kMagicSize;
  try {
    while (const std::optional<McapRecord> record = reader_.read(position)) {
      if (!take(*record)) {
        break;
      }
      position = record->end();
    }
    finish_chunk();
    if (position >= reader_.size()) {
      throw ByteError("it ends without its end");
    }
  } catch (const ByteError& error) {
    file_.damage_ = text_of_damage(file_.path(), position, error.what());
    finish_last_chunk();
  }
}

/// The chunk before damage, whose index may be a part of it.
void McapFile::Scanner::finish_last_chunk() {
  indexed_.clear();
  try {
    finish_chunk();
  } catch (const ByteError&) {
    // It is the damage that is told already.
  }
}

/// Returns whether more may follow.
bool McapFile::Scanner::take(const McapRecord& record) {
  if (record.operation != McapOperation::kMessageIndex) {
    finish_chunk();
  }
  switch (record.operation) {
    case McapOperation::kChunk:
      take_chunk(record);
      break;
    case McapOperation::kMessage:
      take_message(record);
      break;
    case McapOperation::kMessageIndex:
      take_index(record);
      break;
    case McapOperation::kSchema:
    case McapOperation::kChannel:
      if (!record.is_cut) {
        const Bytes content = reader_.bytes(record.content, record.size);
        register_record(record.operation, {content.data(), content.size()});
      }
      break;
    case McapOperation::kDataEnd:
    case McapOperation::kFooter:
      return false;
    default:
      if (static_cast<int>(record.operation) == 0) {
        throw ByteError("there is no record");
      }
  }
  if (record.is_cut) {
    throw ByteError("the file ends within a record");
  }
  return true;
}

void McapFile::Scanner::take_chunk(const McapRecord& record) {
  constexpr std::uint64_t kMostHead = 64;  // bytes, of the fields before the records
  const Bytes head = reader_.bytes(record.content, std::min(record.size, kMostHead));
  ByteReader bytes(head.data(), head.size());
  McapChunk chunk;
  chunk.first = bytes.number<std::uint64_t>();
  chunk.last = std::max<std::uint64_t>(bytes.number<std::uint64_t>(), 1);
  chunk.unpacked_size = bytes.number<std::uint64_t>();
  chunk.checksum = bytes.number<std::uint32_t>();
  chunk.compression = bytes.array().text();
  const auto size = bytes.number<std::uint64_t>();
  if (!chunk.compression.empty() && chunk.compression != "zstd" && chunk.compression != "lz4") {
    throw ByteError(fmt::format("a chunk's compression is '{}'; allowed: none, zstd or lz4",
                                chunk.compression));
  }
  require_time(chunk.first);
  require_time(chunk.last);
  chunk.position = record.content + (head.size() - bytes.size());
  chunk.size = size;
  chunk.is_cut = record.is_cut;
  if (!record.is_cut && chunk.position + size != record.end()) {
    throw ByteError("a chunk's records do not end with it");
  }
  chunk_ = chunk;
  if (record.is_cut) {
    finish_chunk();
  }
}

void McapFile::Scanner::take_index(const McapRecord& record) {
  constexpr std::size_t kEntrySize = 2 * sizeof(std::uint64_t);
  if (record.is_cut) {
    return;
  }
  const Bytes content = reader_.bytes(record.content, record.size);
  ByteReader bytes(content.data(), content.size());
  const auto channel = bytes.number<std::uint16_t>();
  indexed_[channel] += bytes.array().size() / kEntrySize;
}

/// A chunk is unpacked only where its index does not tell what is in it.
void McapFile::Scanner::finish_chunk() {
  if (!chunk_) {
    return;
  }
  const bool is_known = !chunk_->is_cut && !indexed_.empty() &&
                        std::all_of(indexed_.begin(), indexed_.end(), [&](const auto& entry) {
                          return file_.connections_.count(entry.first) > 0;
                        });
  if (is_known) {
    for (const auto& [channel, messages] : indexed_) {
      count(channel, messages);
    }
    add_chunk(*chunk_);
  } else {
    look_into_chunk();
  }
  chunk_.reset();
  indexed_.clear();
}

void McapFile::Scanner::look_into_chunk() {
  std::optional<std::uint64_t> first;
  std::uint64_t last = 0;
  const Bytes records = records_of(*chunk_, reader_);
  visit_mcap_records({records.data(), records.size()}, [&](auto operation, ByteReader content) {
    if (operation == McapOperation::kMessage) {
      const McapMessage message = parse_mcap_message(content);
      require_time(message.time);
      count(message.channel, 1);
      first = std::min(first.value_or(message.time), message.time);
      last = std::max(last, message.time);
    } else {
      register_record(operation, content);
    }
  });
  if (first) {
    McapChunk chunk = *chunk_;
    chunk.first = *first;
    chunk.last = last;
    add_chunk(chunk);
  }
}

/// Messages that are in no chunk: those that follow each other become one.
void McapFile::Scanner::take_message(const McapRecord& record) {
  constexpr std::uint64_t kHead = 9;          // bytes, of a record
  constexpr std::uint64_t kUsualFields = 22;  // bytes, before a message's data
  constexpr std::uint64_t kLargestRun = std::uint64_t{1} << 22U;
  if (record.is_cut) {
    return;
  }
  const Bytes content = reader_.bytes(record.content, std::min(record.size, kUsualFields));
  const McapMessage message = parse_mcap_message({content.data(), content.size()});
  require_time(message.time);
  count(message.channel, 1);
  const std::uint64_t begin = record.content - kHead;
  McapChunk run;
  run.position = begin;
  run.first = message.time;
  run.last = message.time;
  if (!file_.chunks_.empty()) {
    const McapChunk& before = file_.chunks_.back();
    if (before.position + before.size == begin && before.compression.empty() &&
        before.size < kLargestRun) {
      run = before;
      file_.chunks_.pop_back();
    }
  }
  run.size = record.end() - run.position;
  run.unpacked_size = run.size;
  run.checksum = 0;
  run.first = std::min(run.first, message.time);
  run.last = std::max(run.last, message.time);
  add_chunk(run);
}

void McapFile::Scanner::add_chunk(const McapChunk& chunk) {
  file_.last_ = std::max(file_.last_, chunk.last);
  file_.chunks_.push_back(chunk);
}

void McapFile::Scanner::register_record(McapOperation operation, const ByteReader& content) {
  if (operation == McapOperation::kSchema) {
    const McapSchema schema = parse_mcap_schema(content);
    schemas_[schema.id] = ros1_type(schema.name);
  } else if (operation == McapOperation::kChannel) {
    const McapChannel channel = parse_mcap_channel(content);
    const auto schema = schemas_.find(channel.schema);
    BagConnection& connection = file_.connections_[channel.id];
    connection.topic = channel.topic;
    connection.type = schema != schemas_.end() ? schema->second : "";
    connection.md5sum = channel.md5sum;
    file_.encodings_[channel.id] = channel.encoding;
  }
}

void McapFile::Scanner::count(std::uint32_t channel, std::size_t messages) {
  const auto connection = file_.connections_.find(channel);
  if (connection == file_.connections_.end()) {
    throw ByteError(fmt::format("channel {} is not known", channel));
  }
  connection->second.messages += messages;
}

namespace {

/// A message that is still to come.
struct McapEntry {
  std::uint64_t time = 0;  ///< [ns]
  std::uint32_t channel = 0;
  std::shared_ptr<const Bytes> chunk;  ///< holds the data
  ByteReader data;
};

bool is_before(const McapEntry& a, const McapEntry& b) { return a.time < b.time; }

class McapMessages : public RecordedMessages {
 public:
  McapMessages(const McapFile& file, BagSelection selection)
      : file_(file),
        selection_(std::move(selection)),
        first_(selection_.first.toNSec()),
        last_(selection_.last.toNSec()),
        next_chunk_(selection_.connections.empty() ? file.chunks().size() : 0) {}

  std::optional<ros::Time> peek() override {
    const std::vector<McapChunk>& chunks = file_.chunks();
    while (next_chunk_ < chunks.size() && chunks[next_chunk_].first <= last_ &&
           (next_ == read_.size() || chunks[next_chunk_].first <= read_[next_].time)) {
      const McapChunk& chunk = chunks[next_chunk_++];
      if (chunk.last >= first_) {
        add(chunk);
      }
    }
    if (next_ < read_.size()) {
      return to_time(read_[next_].time);
    }
    if (!file_.damage().empty() && !selection_.connections.empty() &&
        selection_.last >= file_.end_time()) {
      throw BagError(file_.damage());
    }
    return std::nullopt;
  }

  RecordedMessage next() override {
    const McapEntry entry = std::move(read_[next_++]);
    const BagConnection& connection = file_.connections().at(entry.channel);
    const std::string& encoding = file_.encoding_of(entry.channel);
    if (encoding != "cdr" && encoding != "ros1") {
      throw BagError(fmt::format(
          "topic {} of bag '{}' has messages in the encoding '{}'; allowed: cdr or ros1",
          connection.topic, file_.path(), encoding));
    }
    try {
      return {to_time(entry.time), &connection,
              encoding == "cdr" ? read_cdr_message(entry.data, connection)
                                : read_ros1_message(entry.data, connection)};
    } catch (const ByteError& error) {
      throw BagError(fmt::format(
          "bag '{}' has a message of topic {} at {:f} s that is none of {} ({})", file_.path(),
          connection.topic, to_time(entry.time).toSec(), connection.type, error.what()));
    }
  }

 private:
  /// Puts a chunk's messages among those that are still to come.
  void add(const McapChunk& chunk) {
    read_.erase(read_.begin(), read_.begin() + static_cast<std::ptrdiff_t>(next_));
    next_ = 0;
    const auto old = static_cast<std::ptrdiff_t>(read_.size());
    McapRecordReader reader(file_.path());  // opened anew, as a drive may be split into many files
    try {
      const auto records = std::make_shared<const Bytes>(records_of(chunk, reader));
      const auto add_message = [&](McapOperation operation, const ByteReader& content) {
        if (operation == McapOperation::kMessage) {
          const McapMessage message = parse_mcap_message(content);
          if (message.time >= first_ && message.time <= last_ &&
              selection_.connections.count(message.channel) > 0) {
            read_.push_back({message.time, message.channel, records, message.data});
          }
        }
      };
      if (!visit_mcap_records({records->data(), records->size()}, add_message) && !chunk.is_cut) {
        throw ByteError("a chunk ends within a record");
      }
    } catch (const ByteError& error) {
      throw BagError(text_of_damage(file_.path(), chunk.position, error.what()));
    }
    std::stable_sort(read_.begin() + old, read_.end(), is_before);
    std::inplace_merge(read_.begin(), read_.begin() + old, read_.end(), is_before);
  }

  const McapFile& file_;
  const BagSelection selection_;
  const std::uint64_t first_;  ///< [ns]
  const std::uint64_t last_;
  std::size_t next_chunk_;
  std::vector<McapEntry> read_;  ///< from `next_` on they are still to come
  std::size_t next_ = 0;
};

}  // namespace

McapFile::McapFile(const std::string& path) : RecordingFile(path) {
  Scanner(*this).scan();
  if (chunks_.empty() && !damage_.empty()) {
    throw BagError(damage_);
  }
  std::stable_sort(chunks_.begin(), chunks_.end(),
                   [](const McapChunk& a, const McapChunk& b) { return a.first < b.first; });
}

ros::Time McapFile::begin_time() const { return to_time(chunks_.front().first); }
ros::Time McapFile::end_time() const { return to_time(last_); }

std::unique_ptr<RecordedMessages> McapFile::messages(BagSelection selection) const {
  return std::make_unique<McapMessages>(*this, std::move(selection));
}

}  // namespace matchbox_slam
