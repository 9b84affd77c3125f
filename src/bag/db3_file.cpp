#include "bag/db3_file.hpp"

#include <fmt/core.h>
#include <sqlite3.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>

#include "bag/bag_error.hpp"
#include "bag/byte_reader.hpp"
#include "bag/cdr_message.hpp"
#include "bag/whole_pages.hpp"

namespace matchbox_slam {
namespace {

constexpr std::int64_t kLatest = 4'294'967'295'000'000'000;  // [ns]

std::string text_of_damage(const std::string& path, const std::string& what) {
  return fmt::format(
      "bag '{}' is damaged ({}); `sqlite3 '{}' .recover | sqlite3 NEW.db3` may save more", path,
      what, path);
}

/// Thrown where the database cannot be read. The text is SQLite's.
class DatabaseError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct StatementCloser {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};

/// A query and the row that it has come to.
class Query {
 public:
  Query(sqlite3* database, const std::string& text) : database_(database) {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(database, text.c_str(), -1, &statement, nullptr) != SQLITE_OK) {
      throw DatabaseError(sqlite3_errmsg(database));
    }
    statement_.reset(statement);
  }

  void bind(int place, std::int64_t value) { sqlite3_bind_int64(statement_.get(), place, value); }

  /// Whether there is another row.
  [[nodiscard]] bool next() {
    const int state = sqlite3_step(statement_.get());
    if (state != SQLITE_ROW && state != SQLITE_DONE) {
      throw DatabaseError(sqlite3_errmsg(database_));
    }
    return state == SQLITE_ROW;
  }

  [[nodiscard]] std::int64_t number(int column) {
    return sqlite3_column_int64(statement_.get(), column);
  }

  [[nodiscard]] std::string text(int column) { return bytes(column).text(); }

  /// Good until the next row.
  [[nodiscard]] ByteReader bytes(int column) {
    // Before its size, as SQLite wants it.
    const void* data = sqlite3_column_blob(statement_.get(), column);
    const int size = sqlite3_column_bytes(statement_.get(), column);
    return {static_cast<const std::uint8_t*>(data), static_cast<std::size_t>(std::max(size, 0))};
  }

 private:
  sqlite3* database_;
  std::unique_ptr<sqlite3_stmt, StatementCloser> statement_;
};

/// A name with everything but plain letters written as SQLite's URIs want it.
std::string uri_of(const std::string& path, const std::string& options) {
  constexpr const char* kDigits = "0123456789ABCDEF";
  std::string uri = "file:";
  for (const char letter : std::filesystem::absolute(path).string()) {
    const auto code = static_cast<unsigned char>(letter);
    if (std::isalnum(code) != 0 || letter == '/' || letter == '.' || letter == '_') {
      uri += letter;
    } else {
      uri += {'%', kDigits[code >> 4U], kDigits[code & 15U]};
    }
  }
  return fmt::format("{}?mode=ro{}", uri, options);
}

Database open_with(const std::string& path, const std::string& options) {
  sqlite3* raw = nullptr;
  const int state = sqlite3_open_v2(uri_of(path, options).c_str(), &raw,
                                    SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, whole_pages_system());
  Database database(raw);
  if (state != SQLITE_OK) {
    throw DatabaseError(raw != nullptr ? sqlite3_errmsg(raw) : "there is not enough memory");
  }
  // Without the first a database that is cut off is not read at all; the others are for those
  // that somebody has tampered with.
  for (const char* setting : {"PRAGMA writable_schema=ON", "PRAGMA trusted_schema=OFF",
                              "PRAGMA cell_size_check=ON", "PRAGMA mmap_size=0"}) {
    sqlite3_exec(database.get(), setting, nullptr, nullptr, nullptr);
  }
  (void)Query(database.get(), "SELECT COUNT(*) FROM sqlite_master").next();
  return database;
}

Database open(const std::string& path) {
  try {
    return open_with(path, "");
  } catch (const DatabaseError&) {
    // One with a log of writes wants to write files beside it, which a folder may not allow; with
    // nothing in that log it does as well without.
    std::error_code error;
    const auto pending = std::filesystem::file_size(path + "-wal", error);
    if (!error && pending > 0) {
      throw;
    }
    return open_with(path, "&immutable=1");
  }
}

ros::Time to_time(std::int64_t nanoseconds) {
  return ros::Time().fromNSec(static_cast<std::uint64_t>(nanoseconds));
}

/// A bag of ROS 1 knows no time 0, and none of both knows what is before or after.
std::int64_t time_within(std::int64_t nanoseconds) {
  if (nanoseconds < 0 || nanoseconds > kLatest) {
    throw DatabaseError("a message is said to be of before 1970 or after 2106");
  }
  return std::max<std::int64_t>(nanoseconds, 1);
}

/// What is asked for, in the order of time.
std::string query_of(const BagSelection& selection) {
  std::string topics;
  for (const std::uint32_t topic : selection.connections) {
    topics += fmt::format("{}{}", topics.empty() ? "" : ",", topic);
  }
  return fmt::format(
      "SELECT timestamp, topic_id, data FROM messages WHERE timestamp BETWEEN ?1 AND ?2 AND "
      "topic_id IN ({}) ORDER BY timestamp, id",
      topics);
}

class Db3Messages : public RecordedMessages {
 public:
  /// @param damage  what to throw at the end; empty: nothing.
  Db3Messages(const Db3File& file, BagSelection selection, std::string damage)
      : file_(file), selection_(std::move(selection)), damage_(std::move(damage)) {}

  std::optional<ros::Time> peek() override {
    if (!is_at_row_ && !is_over_ && !selection_.connections.empty()) {
      step();
    }
    if (!is_at_row_ && !damage_.empty()) {
      throw BagError(damage_);
    }
    return is_at_row_ ? std::optional(time_) : std::nullopt;
  }

  RecordedMessage next() override {
    is_at_row_ = false;
    const BagConnection& connection =
        file_.connections().at(static_cast<std::uint32_t>(query_->number(1)));
    try {
      return {time_, &connection, read_cdr_message(query_->bytes(2), connection)};
    } catch (const ByteError& error) {
      throw BagError(fmt::format(
          "bag '{}' has a message of topic {} at {:f} s that is none of {} ({})", file_.path(),
          connection.topic, time_.toSec(), connection.type, error.what()));
    }
  }

 private:
  void step() {
    is_over_ = true;  // should this fail
    try {
      if (!query_) {
        database_ = open(file_.path());  // only now, as a drive may be split into many files
        query_.emplace(database_.get(), query_of(selection_));
        query_->bind(1, lowest());
        query_->bind(2, static_cast<std::int64_t>(
                            std::min<std::uint64_t>(selection_.last.toNSec(), kLatest)));
      }
      is_at_row_ = query_->next();
      is_over_ = !is_at_row_;
      if (is_at_row_) {
        time_ = to_time(time_within(query_->number(0)));
      } else {
        query_.reset();
        database_.reset();
      }
    } catch (const DatabaseError& error) {
      throw BagError(text_of_damage(file_.path(), error.what()));
    }
  }

  /// A time of 0 was taken for 1 ns.
  [[nodiscard]] std::int64_t lowest() const {
    const auto first =
        static_cast<std::int64_t>(std::min<std::uint64_t>(selection_.first.toNSec(), kLatest));
    return first <= 1 ? 0 : first;
  }

  const Db3File& file_;
  const BagSelection selection_;
  const std::string damage_;
  Database database_;
  std::optional<Query> query_;
  ros::Time time_;  ///< of the row
  bool is_at_row_ = false;
  bool is_over_ = false;
};

}  // namespace

void DatabaseCloser::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

Db3File::Db3File(const std::string& path) : RecordingFile(path) {
  try {
    const Database database = open(path);
    read_topics(database.get());
    count_messages(database.get());
  } catch (const DatabaseError& error) {
    throw BagError(text_of_damage(path, error.what()));
  }
  if (empty() && !damage_.empty()) {
    throw BagError(damage_);
  }
}

void Db3File::read_topics(sqlite3* database) {
  Query tables(database, "SELECT COUNT(*) FROM sqlite_master WHERE name IN ('topics', 'messages')");
  if (!tables.next() || tables.number(0) != 2) {
    throw BagError(fmt::format(
        "'{}' is an SQLite database, but no bag of ROS 2: that has the tables topics and messages",
        path()));
  }
  Query topics(database, "SELECT id, name, type, serialization_format FROM topics");
  while (topics.next()) {
    const std::int64_t id = topics.number(0);
    if (id < 0 || id > std::numeric_limits<std::uint32_t>::max()) {
      throw DatabaseError(fmt::format("a topic has the number {}", id));
    }
    BagConnection& connection = connections_[static_cast<std::uint32_t>(id)];
    connection.topic = topics.text(1);
    connection.type = ros1_type(topics.text(2));
    const std::string format = topics.text(3);
    if (format != "cdr") {
      // It may be one that nobody asks for.
      connection.type += fmt::format(" in the format '{}'", format);
    }
  }
}

void Db3File::count_messages(sqlite3* database) {
  try {
    Query messages(database, "SELECT topic_id, timestamp FROM messages");
    while (messages.next()) {
      const auto found = connections_.find(static_cast<std::uint32_t>(messages.number(0)));
      if (found == connections_.end()) {
        throw DatabaseError("a message is of a topic that is not known");
      }
      const std::int64_t time = time_within(messages.number(1));
      first_ = empty() ? time : std::min(first_, time);
      last_ = std::max(last_, time);
      ++found->second.messages;
    }
  } catch (const DatabaseError& error) {
    damage_ = text_of_damage(path(), error.what());
  }
}

ros::Time Db3File::begin_time() const { return to_time(first_); }
ros::Time Db3File::end_time() const { return to_time(last_); }

std::unique_ptr<RecordedMessages> Db3File::messages(BagSelection selection) const {
  const bool reaches_end = !selection.connections.empty() && selection.last >= end_time();
  return std::make_unique<Db3Messages>(*this, std::move(selection), reaches_end ? damage_ : "");
}

}  // namespace matchbox_slam
