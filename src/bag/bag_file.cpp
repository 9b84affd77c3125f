#include "bag/bag_file.hpp"

#include <rosbag/chunked_file.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <system_error>
#include <tuple>
#include <utility>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kVersionLine = 13;  // bytes, "#ROSBAG V2.0" and the end of its line

enum Operation : std::uint8_t {
  kMessage = 0x02,
  kBagHeader = 0x03,
  kIndex = 0x04,
  kChunk = 0x05,
  kChunkInfo = 0x06,
  kConnection = 0x07
};

// No recorder comes near these; a length beyond them is damage, not worth trying to get the memory.
constexpr std::uint32_t kLongestHeader = 1U << 24U;
constexpr std::uint32_t kLargestChunk = 1U << 30U;

std::string repair(const std::string& path) {
  return "; run `rosbag reindex " + path + "` and try again";
}

[[noreturn]] void throw_damaged(const std::string& path, std::uint64_t position,
                                const std::string& what) {
  throw BagError("bag '" + path + "' is damaged at byte " + std::to_string(position) + " (" + what +
                 ")" + repair(path));
}

void require_readable_file(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) {
    throw ConfigurationError("bag '" + path + "' does not exist");
  }
  if (fs::is_directory(status)) {
    throw ConfigurationError("bag '" + path + "' is a folder, not a bag file");
  }
  if (fs::is_regular_file(status) && fs::file_size(path, error) == 0) {
    throw BagError("bag '" + path + "' is empty (0 bytes)");
  }
  const std::string version = "#ROSBAG V2.0";
  std::string beginning(version.size(), ' ');
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw BagError("bag '" + path + "' may not be read");
  }
  if (!file.read(beginning.data(), static_cast<std::streamsize>(beginning.size())) ||
      beginning != version) {
    throw BagError("'" + path + "' is no bag of version 2.0; it begins with other bytes than '" +
                   version + "'");
  }
}

std::uint64_t size_of(std::ifstream& stream) {
  stream.seekg(0, std::ios::end);
  return static_cast<std::uint64_t>(stream.tellg());
}

/// The fields of a record's header: name=value, each after its length.
class Fields {
 public:
  explicit Fields(ByteReader bytes) {
    while (!bytes.empty()) {
      const ByteReader field = bytes.array();
      const std::string text = field.text();
      const std::size_t equals = text.find('=');
      if (equals == std::string::npos || equals == 0) {
        throw ByteError("a field of a header is not name=value");
      }
      values_[text.substr(0, equals)] = text.substr(equals + 1);
    }
  }

  [[nodiscard]] const std::string& text(const std::string& name) const {
    const auto found = values_.find(name);
    if (found == values_.end()) {
      throw ByteError("a header has no field '" + name + "'");
    }
    return found->second;
  }

  template <typename Number>
  [[nodiscard]] Number number(const std::string& name) const {
    const std::string& bytes = text(name);
    if (bytes.size() != sizeof(Number)) {
      throw ByteError("field '" + name + "' of a header has " + std::to_string(bytes.size()) +
                      " bytes, not " + std::to_string(sizeof(Number)));
    }
    Number value{};
    std::memcpy(&value, bytes.data(), sizeof(Number));
    return value;
  }

  void require(Operation operation) const {
    if (const auto op = number<std::uint8_t>("op"); op != operation) {
      throw ByteError("a record has the operation " + std::to_string(op) + " where " +
                      std::to_string(operation) + " is expected");
    }
  }

 private:
  std::map<std::string, std::string> values_;
};

/// A record of the file: a header, and data that may be large.
struct Record {
  Fields fields;
  std::uint64_t data = 0;  ///< position
  std::uint32_t data_size = 0;

  [[nodiscard]] std::uint64_t end() const { return data + data_size; }
};

std::vector<std::uint8_t> read_bytes(std::ifstream& stream, std::uint64_t position,
                                     std::uint32_t count, std::uint64_t file_size) {
  if (position > file_size || count > file_size - position) {
    throw ByteError("it goes beyond the end of the file, which may be cut off");
  }
  std::vector<std::uint8_t> bytes(count);
  stream.clear();
  stream.seekg(static_cast<std::streamoff>(position));
  // Streams read characters. NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
  if (!stream) {
    throw ByteError("the file cannot be read there");
  }
  return bytes;
}

std::uint32_t read_length(std::ifstream& stream, std::uint64_t position, std::uint64_t file_size) {
  const std::vector<std::uint8_t> bytes =
      read_bytes(stream, position, sizeof(std::uint32_t), file_size);
  return ByteReader(bytes.data(), bytes.size()).number<std::uint32_t>();
}

Record read_record(std::ifstream& stream, std::uint64_t position, std::uint64_t file_size) {
  const std::uint32_t header_size = read_length(stream, position, file_size);
  if (header_size > kLongestHeader) {
    throw ByteError("a header is said to have " + std::to_string(header_size) + " bytes");
  }
  const std::vector<std::uint8_t> header =
      read_bytes(stream, position + sizeof(std::uint32_t), header_size, file_size);
  const std::uint64_t after_header = position + sizeof(std::uint32_t) + header_size;
  Record record{Fields(ByteReader(header.data(), header.size())),
                after_header + sizeof(std::uint32_t), read_length(stream, after_header, file_size)};
  if (record.end() > file_size) {
    throw ByteError("it goes beyond the end of the file, which may be cut off");
  }
  return record;
}

/// Reads what the constructor of BagFile wants to know, from the end of the bag backwards.
class IndexReader {
 public:
  explicit IndexReader(const std::string& path)
      : path_(path), stream_(path, std::ios::binary), size_(size_of(stream_)) {}

  void read(std::map<std::uint32_t, BagConnection>& connections, std::vector<BagEntry>& entries) {
    try {
      read_all(connections, entries);
    } catch (const ByteError& error) {
      throw_damaged(path_, position_, error.what());
    }
  }

 private:
  Record read_at(std::uint64_t position, Operation operation) {
    position_ = position;
    Record record = read_record(stream_, position, size_);
    record.fields.require(operation);
    return record;
  }

  std::vector<std::uint8_t> data_of(const Record& record) {
    return read_bytes(stream_, record.data, record.data_size, size_);
  }

  void read_all(std::map<std::uint32_t, BagConnection>& connections,
                std::vector<BagEntry>& entries) {
    const Record header = read_at(kVersionLine, kBagHeader);
    std::uint64_t next = header.fields.number<std::uint64_t>("index_pos");
    if (next == 0) {
      throw BagError("bag '" + path_ + "' has no index, as its recording did not end properly" +
                     repair(path_));
    }
    const auto connection_count = header.fields.number<std::uint32_t>("conn_count");
    const auto chunk_count = header.fields.number<std::uint32_t>("chunk_count");
    for (std::uint32_t i = 0; i < connection_count; ++i) {
      const Record record = read_at(next, kConnection);
      add_connection(record, connections);
      next = record.end();
    }
    for (std::uint32_t i = 0; i < chunk_count; ++i) {
      const Record info = read_at(next, kChunkInfo);
      next = info.end();
      read_chunk_index(info, connections, entries);
    }
  }

  void add_connection(const Record& record, std::map<std::uint32_t, BagConnection>& connections) {
    const std::vector<std::uint8_t> data = data_of(record);
    const Fields sent(ByteReader(data.data(), data.size()));
    connections[record.fields.number<std::uint32_t>("conn")] = {
        record.fields.text("topic"), sent.text("type"), sent.text("md5sum")};
  }

  /// The index records that follow a chunk, one for each connection in it.
  void read_chunk_index(const Record& info,
                        const std::map<std::uint32_t, BagConnection>& connections,
                        std::vector<BagEntry>& entries) {
    const auto chunk_position = info.fields.number<std::uint64_t>("chunk_pos");
    const auto index_count = info.fields.number<std::uint32_t>("count");
    const Record chunk = read_at(chunk_position, kChunk);
    const auto unpacked_size = chunk.fields.number<std::uint32_t>("size");
    std::uint64_t next = chunk.end();
    for (std::uint32_t i = 0; i < index_count; ++i) {
      const Record index = read_at(next, kIndex);
      next = index.end();
      BagEntry entry;
      entry.chunk = chunk_position;
      entry.connection = index.fields.number<std::uint32_t>("conn");
      if (connections.count(entry.connection) == 0) {
        throw ByteError("connection " + std::to_string(entry.connection) + " is not known");
      }
      const std::vector<std::uint8_t> data = data_of(index);
      ByteReader bytes(data.data(), data.size());
      for (auto left = index.fields.number<std::uint32_t>("count"); left > 0; --left) {
        entry.time.sec = bytes.number<std::uint32_t>();
        entry.time.nsec = bytes.number<std::uint32_t>();
        entry.offset = bytes.number<std::uint32_t>();
        if (entry.time.nsec >= 1'000'000'000U || entry.offset >= unpacked_size) {
          throw ByteError("an entry of an index points nowhere");
        }
        entries.push_back(entry);
      }
    }
  }

  std::string path_;
  std::ifstream stream_;
  std::uint64_t size_;
  std::uint64_t position_ = 0;  ///< of the record that is being read
};

/// Unpacks a chunk's data to so many bytes.
std::vector<std::uint8_t> unpack(std::vector<std::uint8_t> packed, const std::string& compression,
                                 std::uint32_t size) {
  if (compression == "none") {
    if (packed.size() != size) {
      throw ByteError("a chunk of " + std::to_string(size) + " bytes has " +
                      std::to_string(packed.size()));
    }
    return packed;
  }
  if (compression != "bz2" && compression != "lz4") {
    throw ByteError("a chunk's compression is neither none, bz2 nor lz4");
  }
  if (size > kLargestChunk) {
    throw ByteError("a chunk is said to unpack to " + std::to_string(size) + " bytes");
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
    const Fields fields(bytes.array());
    const ByteReader data = bytes.array();
    if (fields.number<std::uint8_t>("op") != kConnection) {
      fields.require(kMessage);
      if (fields.number<std::uint32_t>("conn") != connection) {
        throw ByteError("a message is not of the connection that the index says");
      }
      return data;
    }
  }
}

}  // namespace

BagFile::BagFile(std::string path) : path_(std::move(path)) {
  require_readable_file(path_);
  IndexReader(path_).read(connections_, entries_);
  std::sort(entries_.begin(), entries_.end(), [](const BagEntry& a, const BagEntry& b) {
    return std::tie(a.time, a.chunk, a.offset) < std::tie(b.time, b.chunk, b.offset);
  });
  entries_.shrink_to_fit();
}

BagMessageReader::BagMessageReader(const BagFile& file)
    : bag_(file), stream_(file.path(), std::ios::binary), size_(size_of(stream_)) {}

ByteReader BagMessageReader::read(const BagEntry& entry) {
  try {
    if (entry.chunk != position_) {
      load_chunk(entry.chunk);
    }
    ByteReader chunk(chunk_.data(), chunk_.size());
    (void)chunk.take(entry.offset);
    return find_message(chunk, entry.connection);
  } catch (const ByteError& error) {
    throw_damaged(bag_.path(), entry.chunk, error.what());
  }
}

void BagMessageReader::load_chunk(std::uint64_t position) {
  position_ = 0;  // none, should this fail
  const Record record = read_record(stream_, position, size_);
  record.fields.require(kChunk);
  chunk_ = unpack(read_bytes(stream_, record.data, record.data_size, size_),
                  record.fields.text("compression"), record.fields.number<std::uint32_t>("size"));
  position_ = position;
}

}  // namespace matchbox_slam
