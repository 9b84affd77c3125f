#pragma once

#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bag/bag_reader.hpp"
#include "bag/cdr_writer.hpp"

namespace matchbox_slam {

/// A message as ROS 2 records it.
struct Ros2Message {
  std::string topic;
  std::string type;  ///< such as "sensor_msgs/msg/LaserScan"
  std::uint64_t time = 0;
  std::string bytes;        ///< in CDR
  std::string md5sum = {};  ///< of a message of ROS 1
};

/// All messages that are read of a bag of ROS 1, as ROS 2 would have recorded them.
[[nodiscard]] inline std::vector<Ros2Message> as_ros2(const std::string& bag,
                                                      bool is_little_endian = true) {
  std::vector<Ros2Message> messages;
  const BagReader reader({bag});
  const auto stream = reader.messages([](const BagConnection& /*all*/) { return true; }, {});
  while (const auto message = stream->next()) {
    messages.push_back({message->connection->topic, ros2_type(message->connection->type),
                        message->time.toNSec(), to_cdr(message->content, is_little_endian)});
  }
  return messages;
}

[[nodiscard]] inline std::string pack_zstd(const std::string& bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 1));
  return packed;
}

[[nodiscard]] inline std::string pack_lz4(const std::string& bytes) {
  std::string packed(LZ4F_compressFrameBound(bytes.size(), nullptr), '\0');
  packed.resize(
      LZ4F_compressFrame(packed.data(), packed.size(), bytes.data(), bytes.size(), nullptr));
  return packed;
}

/// How a file of MCAP is written.
struct McapRecipe {
  std::string compression;          ///< "", "lz4" or "zstd"
  std::size_t chunk_messages = 40;  ///< 0: messages are in no chunk
  bool with_index = true;
  bool with_summary = true;
  std::string encoding = "cdr";
};

/// Writes MCAP by its specification (mcap.dev/spec).
class McapWriter {
 public:
  explicit McapWriter(McapRecipe recipe) : recipe_(std::move(recipe)) {
    file_ = "\x89MCAP0\r\n";
    file_ += record(0x01, text("ros2") + text("test"));
  }

  void add(const Ros2Message& message) {
    const auto [at, is_new] =
        channels_.emplace(message.topic, static_cast<std::uint16_t>(channels_.size() + 1));
    const std::uint16_t id = at->second;
    if (is_new) {
      const std::string schema =
          record(0x03, raw(id) + text(message.type) + text("ros2msg") + text(""));
      const std::string metadata =
          message.md5sum.empty() ? "" : text("md5sum") + text(message.md5sum);
      const std::string channel = record(
          0x04, raw(id) + raw(id) + text(message.topic) + text(recipe_.encoding) + text(metadata));
      declared_ += schema + channel;
      chunk_ += schema + channel;
    }
    index_[id].emplace_back(message.time, chunk_.size());
    chunk_ += record(0x05, raw(id) + raw<std::uint32_t>(0) + raw(message.time) + raw(message.time) +
                               message.bytes);
    first_ = std::min(first_, message.time);
    last_ = std::max(last_, message.time);
    if (++in_chunk_ >= recipe_.chunk_messages) {
      finish_chunk();
    }
  }

  [[nodiscard]] std::string finish() {
    finish_chunk();
    file_ += record(0x0F, raw<std::uint32_t>(0));
    const auto summary = static_cast<std::uint64_t>(recipe_.with_summary ? file_.size() : 0);
    file_ += recipe_.with_summary ? declared_ : "";
    file_ += record(0x02, raw(summary) + raw<std::uint64_t>(0) + raw<std::uint32_t>(0));
    return file_ + "\x89MCAP0\r\n";
  }

 private:
  template <typename Number>
  static std::string raw(Number value) {
    return {reinterpret_cast<const char*>(&value), sizeof(value)};
  }
  static std::string text(const std::string& text) {
    return raw(static_cast<std::uint32_t>(text.size())) + text;
  }
  static std::string record(char operation, const std::string& content) {
    return operation + raw(static_cast<std::uint64_t>(content.size())) + content;
  }

  void finish_chunk() {
    if (recipe_.chunk_messages == 0 || in_chunk_ == 0) {
      file_ += chunk_;
      chunk_.clear();
      return;
    }
    const std::string packed = recipe_.compression == "zstd"  ? pack_zstd(chunk_)
                               : recipe_.compression == "lz4" ? pack_lz4(chunk_)
                                                              : chunk_;
    const auto checksum = static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(chunk_.data()), static_cast<uInt>(chunk_.size())));
    file_ +=
        record(0x06, raw(first_) + raw(last_) + raw(static_cast<std::uint64_t>(chunk_.size())) +
                         raw(checksum) + text(recipe_.compression) +
                         raw(static_cast<std::uint64_t>(packed.size())) + packed);
    for (const auto& [id, entries] : index_) {
      std::string content;
      for (const auto& [time, offset] : entries) {
        content += raw(time) + raw(static_cast<std::uint64_t>(offset));
      }
      file_ += recipe_.with_index ? record(0x07, raw(id) + text(content)) : "";
    }
    index_.clear();
    chunk_.clear();
    in_chunk_ = 0;
    first_ = UINT64_MAX;
    last_ = 0;
  }

  McapRecipe recipe_;
  std::string file_;
  std::string declared_;  ///< schemas and channels
  std::map<std::string, std::uint16_t> channels_;
  std::string chunk_;
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::size_t>>> index_;
  std::size_t in_chunk_ = 0;
  std::uint64_t first_ = UINT64_MAX;
  std::uint64_t last_ = 0;
};

[[nodiscard]] inline std::string to_mcap(const std::vector<Ros2Message>& messages,
                                         const McapRecipe& recipe = {}) {
  McapWriter writer(recipe);
  for (const Ros2Message& message : messages) {
    writer.add(message);
  }
  return writer.finish();
}

inline void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// Writes a database as rosbag2's storage plugin for SQLite does (schema 3).
/// @param packs_messages  each by zstd, as `--compression-mode message` does.
inline void write_db3(const std::string& path, const std::vector<Ros2Message>& messages,
                      bool packs_messages = false) {
  sqlite3* database = nullptr;
  const auto run = [&](const std::string& statement) {
    if (sqlite3_exec(database, statement.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) {
      throw std::runtime_error(sqlite3_errmsg(database));
    }
  };
  sqlite3_open(path.c_str(), &database);
  run("PRAGMA synchronous=OFF");
  run("CREATE TABLE schema(schema_version INTEGER PRIMARY KEY,ros_distro TEXT NOT NULL)");
  run("CREATE TABLE metadata(id INTEGER PRIMARY KEY,metadata_version INTEGER NOT NULL,metadata "
      "TEXT NOT NULL)");
  run("CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,"
      "serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL)");
  run("CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER "
      "NOT NULL, data BLOB NOT NULL)");
  run("CREATE INDEX timestamp_idx ON messages (timestamp ASC)");
  run("BEGIN");
  std::map<std::string, int> topics;
  for (const Ros2Message& message : messages) {
    const auto [at, is_new] = topics.emplace(message.topic, static_cast<int>(topics.size()) + 1);
    if (is_new) {
      run("INSERT INTO topics VALUES(" + std::to_string(at->second) + ",'" + message.topic + "','" +
          message.type + "','cdr','')");
    }
    sqlite3_stmt* insert = nullptr;
    sqlite3_prepare_v2(database,
                       "INSERT INTO messages(topic_id, timestamp, data) VALUES(?1, ?2, ?3)", -1,
                       &insert, nullptr);
    const std::string bytes = packs_messages ? pack_zstd(message.bytes) : message.bytes;
    sqlite3_bind_int(insert, 1, at->second);
    sqlite3_bind_int64(insert, 2, static_cast<sqlite3_int64>(message.time));
    sqlite3_bind_blob(insert, 3, bytes.data(), static_cast<int>(bytes.size()), SQLITE_TRANSIENT);
    sqlite3_step(insert);
    sqlite3_finalize(insert);
  }
  run("COMMIT");
  sqlite3_close(database);
}

}  // namespace matchbox_slam
