#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "bag/recording_file.hpp"

// As SQLite declares it, so that not all who include this need its headers.
struct sqlite3;

namespace matchbox_slam {

struct DatabaseCloser {
  void operator()(sqlite3* database) const;
};
using Database = std::unique_ptr<sqlite3, DatabaseCloser>;

/// A bag of ROS 2 in an SQLite database, with its messages as they were sent or each packed by
/// zstd. One that is cut off is read as far as it goes.
class Db3File : public RecordingFile {
 public:
  /// Throws BagError where nothing in it can be read.
  explicit Db3File(const std::string& path);

  [[nodiscard]] const std::map<std::uint32_t, BagConnection>& connections() const override {
    return connections_;
  }
  [[nodiscard]] bool empty() const override { return first_ > last_; }
  [[nodiscard]] ros::Time begin_time() const override;
  [[nodiscard]] ros::Time end_time() const override;
  [[nodiscard]] std::unique_ptr<RecordedMessages> messages(BagSelection selection) const override;

 private:
  void read_topics(sqlite3* database);
  void count_messages(sqlite3* database);

  std::map<std::uint32_t, BagConnection> connections_;  ///< by the number of their topic
  std::int64_t first_ = 1;                              ///< [ns]
  std::int64_t last_ = 0;
  std::string damage_;  ///< why not all can be read; empty: it can
};

}  // namespace matchbox_slam
