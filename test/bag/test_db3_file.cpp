#include <gtest/gtest.h>
#include <sys/resource.h>

#include <filesystem>

#include "bag/bag_error.hpp"
#include "bag/db3_file.hpp"
#include "bag/ros2_recordings.hpp"
#include "bag/ros2_test.hpp"
#include "common/error_text.hpp"
#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

class ReadDb3 : public Ros2Test {
 protected:
  explicit ReadDb3(int scans = 20) : Ros2Test("whole 100%.db3", scans) {}
};

TEST_F(ReadDb3, GivesTheMessagesOfABagPackedOneByOneOrNot) {
  const std::vector<Said> expected = all_of({bag_});
  for (const bool packs_messages : {false, true}) {
    std::filesystem::remove(path_);
    write_db3(path_, messages_, packs_messages);
    EXPECT_TRUE(all_of({path_}) == expected);
  }
  const BagReader reader({path_});
  const BagReader bag({bag_});
  EXPECT_EQ(reader.begin_time(), bag.begin_time());
  EXPECT_EQ(reader.end_time(), bag.end_time());
  EXPECT_EQ(reader.topics_of("tf2_msgs/TFMessage"), bag.topics_of("tf2_msgs/TFMessage"));
}

/// Changes a database by statements of SQL.
void change(const std::string& path, const std::string& statements) {
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  ASSERT_EQ(sqlite3_exec(database, statements.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
      << sqlite3_errmsg(database);
  sqlite3_close(database);
}

TEST_F(ReadDb3, ReadsTheTablesOfAllReleasesOfRos2) {
  const std::vector<Said> expected = all_of({bag_});
  write_db3(path_, messages_);
  // From Iron on (schema 4).
  change(path_,
         "ALTER TABLE topics ADD COLUMN type_description_hash TEXT NOT NULL DEFAULT '';"
         "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY,topic_type TEXT NOT NULL,"
         "encoding TEXT NOT NULL,encoded_message_definition TEXT NOT NULL,"
         "type_description_hash TEXT NOT NULL)");
  EXPECT_TRUE(all_of({path_}) == expected);
  // Up to Dashing (schema 1), Foxy having what lies between.
  change(path_,
         "CREATE TABLE old(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,"
         "serialization_format TEXT NOT NULL);"
         "INSERT INTO old SELECT id,name,type,serialization_format FROM topics;"
         "DROP TABLE topics; ALTER TABLE old RENAME TO topics;"
         "DROP TABLE message_definitions; DROP TABLE schema; DROP TABLE metadata");
  EXPECT_TRUE(all_of({path_}) == expected);
}

TEST_F(ReadDb3, WhatWasRecordedOutOfOrderComesInTheOrderOfTime) {
  const std::vector<Said> expected = all_of({bag_});
  std::reverse(messages_.begin(), messages_.end());
  write_db3(path_, messages_);
  const std::vector<Said> read = all_of({path_});
  ASSERT_EQ(read.size(), expected.size());
  for (std::size_t k = 0; k < read.size(); ++k) {
    EXPECT_EQ(read[k].time, expected[k].time) << k;
  }
}

TEST_F(ReadDb3, ReadsAPeriodAndTheStaticTransformsBefore) {
  write_db3(path_, messages_);
  const BagReader reader({path_});
  const BagPeriod period{1.0, 0.5};
  const auto stream = reader.stream({"/scan"}, period);
  const BagReader bag({bag_});
  const auto bag_stream = bag.stream({"/scan"}, period);
  int messages = 0;
  for (; const auto message = stream->next(); ++messages) {
    const auto of_bag = bag_stream->next();
    ASSERT_TRUE(of_bag);
    EXPECT_EQ(message->time, of_bag->time);
    EXPECT_EQ(message->content.index(), of_bag->content.index());
    const auto* transforms = std::get_if<BagTransforms>(&message->content);
    EXPECT_EQ(transforms != nullptr && transforms->is_static, messages == 0);
  }
  EXPECT_FALSE(bag_stream->next());
  EXPECT_GT(messages, 15);
}

class ReadLargeDb3 : public ReadDb3 {
 protected:
  ReadLargeDb3() : ReadDb3(400) {}
};

TEST_F(ReadLargeDb3, CutOffItIsReadAsFarAsItGoes) {
  const std::vector<Said> expected = all_of({bag_});
  write_db3(path_, messages_);
  const std::string bytes = read_file(path_);
  std::size_t most = 0;
  for (std::size_t size = 1; size < bytes.size(); size += 20123) {
    write_bytes(path_, bytes.substr(0, size));
    std::vector<Said> read;
    std::string damage;
    try {
      read = all_of({path_}, &damage);
    } catch (const BagError& error) {
      damage = error.what();
    }
    EXPECT_TRUE(std::equal(read.begin(), read.end(), expected.begin())) << size;
    EXPECT_TRUE(contains(damage, path_)) << size << ": " << damage;
    most = std::max(most, read.size());
  }
  EXPECT_GT(most, expected.size() / 2);
}

TEST_F(ReadDb3, SaysWhatItCannotRead) {
  sqlite3* database = nullptr;
  sqlite3_open(path_.c_str(), &database);
  sqlite3_exec(database, "CREATE TABLE t(x)", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  EXPECT_EQ(error_text<BagError>([&] { (void)all_of({path_}); }),
            "'" + path_ +
                "' is an SQLite database, but no bag of ROS 2: that has the tables topics and "
                "messages");
  std::filesystem::remove(path_);
  write_db3(path_, {});
  EXPECT_EQ(error_text<BagError>([&] { (void)all_of({path_}); }),
            "bag '" + path_ + "' holds no messages");
  std::filesystem::remove(path_);
  messages_.front().bytes = "x";
  write_db3(path_, messages_);
  const std::string text = error_text<BagError>([&] { (void)all_of({path_}); });
  EXPECT_TRUE(contains(text, "has a message of topic " + messages_.front().topic)) << text;
}

// --- their folder ---

class ReadRos2Folder : public ReadDb3 {
 protected:
  ReadRos2Folder() {
    std::filesystem::create_directory(bag_folder_);
    const auto middle = messages_.begin() + static_cast<std::ptrdiff_t>(messages_.size() / 2);
    write_db3(bag_folder_ + "/drive_0.db3", {messages_.begin(), middle});
    write_bytes(bag_folder_ + "/drive_1.mcap", to_mcap({middle, messages_.end()}));
  }

  void write_metadata(const std::string& files) {
    write_bytes(bag_folder_ + "/metadata.yaml",
                "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n"
                "  relative_file_paths:\n" +
                    files);
  }

  std::string bag_folder_ = folder_ / "drive";
};

TEST_F(ReadRos2Folder, IsOneRecordingOfTheFilesThatItsMetadataNames) {
  const std::vector<Said> expected = all_of({bag_});
  write_metadata("    - drive_0.db3\n    - drive/drive_1.mcap\n");
  EXPECT_TRUE(all_of({bag_folder_}) == expected);
  std::filesystem::remove(bag_folder_ + "/metadata.yaml");
  EXPECT_TRUE(all_of({bag_folder_}) == expected);
}

TEST_F(ReadRos2Folder, FilesWithoutMessagesAreToldAndTheOthersRead) {
  const std::vector<Said> expected = all_of({bag_});
  write_bytes(bag_folder_ + "/drive_2.db3", "");
  write_db3(bag_folder_ + "/drive_3.db3", {});
  write_bytes(bag_folder_ + "/drive_4.mcap", to_mcap({}));
  write_metadata(
      "    - drive_0.db3\n    - drive_1.mcap\n    - drive_2.db3\n    - drive_3.db3\n"
      "    - drive_4.mcap\n");
  EXPECT_TRUE(all_of({bag_folder_}) == expected);
  EXPECT_EQ(BagReader({bag_folder_}).remarks(),
            (std::vector<std::string>{
                "'" + bag_folder_ + "/drive_2.db3' is empty (0 bytes) and left out",
                "'" + bag_folder_ + "/drive_3.db3' holds no messages and is left out",
                "'" + bag_folder_ + "/drive_4.mcap' holds no messages and is left out"}));
  write_metadata("    - drive_2.db3\n    - drive_3.db3\n");
  EXPECT_EQ(error_text<BagError>([&] { (void)all_of({bag_folder_}); }),
            "bag '" + bag_folder_ + "' holds no messages in any of its files");
}

/// Lowers how many files the process may have open.
class FewOpenFiles {
 public:
  explicit FewOpenFiles(rlim_t most) {
    getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit lowered{most, before_.rlim_max};
    setrlimit(RLIMIT_NOFILE, &lowered);
  }
  FewOpenFiles(const FewOpenFiles&) = delete;
  FewOpenFiles& operator=(const FewOpenFiles&) = delete;
  ~FewOpenFiles() { setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_{};
};

/// As crystal, dashing, foxy, humble, iron and jazzy write it: what is told of topics, files and
/// their quality of service has changed, where the files are named has not.
TEST_F(ReadRos2Folder, WithTheMetadataOfAnyRelease) {
  const std::vector<Said> expected = all_of({bag_});
  const std::string file = bag_folder_ + "/drive_0.db3";
  for (const auto& entry : std::filesystem::directory_iterator(bag_folder_)) {
    std::filesystem::remove(entry.path());
  }
  write_db3(file, messages_);
  const std::string beginning =
      "  duration:\n    nanoseconds: 5000\n"
      "  starting_time:\n    nanoseconds_since_epoch: 1000\n  message_count: 7\n"
      "  topics_with_message_count:\n    - topic_metadata:\n        name: /scan\n";
  const std::string count = "      message_count: 7\n";
  const std::string cdr = "        serialization_format: cdr\n";
  const std::string type = "        type: sensor_msgs/msg/LaserScan\n" + cdr;
  const std::string packing = "  compression_format: \"\"\n  compression_mode: \"\"\n";
  const std::string names = "  relative_file_paths:\n    - ";
  const std::string quality = "        offered_qos_profiles: \"- history: 3\\n  depth: 0\"\n";
  const std::string listed_quality =
      "        offered_qos_profiles:\n          - history: unknown\n            depth: 0\n"
      "            deadline:\n              sec: 9223372036\n";
  const std::string files =
      "  files:\n    - path: drive_0.db3\n      message_count: 7\n  custom_data: ~\n";
  const std::vector<std::string> told = {
      "  version: 1\n  storage_identifier: sqlite3\n" + names + "drive/drive_0.db3\n" + beginning +
          "        type: sensor_msgs/LaserScan\n" + cdr + count,
      "  version: 3\n  storage_identifier: sqlite3\n" + names + "drive_0.db3\n" + beginning + type +
          count + packing,
      "  version: 4\n  storage_identifier: sqlite3\n" + names + "drive_0.db3\n" + beginning + type +
          quality + count + packing,
      "  version: 5\n  storage_identifier: sqlite3\n" + beginning + type + quality + count +
          packing + names + "drive_0.db3\n" + files,
      "  version: 7\n  storage_identifier: sqlite3\n" + beginning + type + quality +
          "        type_description_hash: \"\"\n" + count + packing + names + "drive_0.db3\n" +
          files,
      "  version: 9\n  storage_identifier: sqlite3\n" + beginning + type + listed_quality +
          "        type_description_hash: RIHS01_64c19189\n" + count + packing + names +
          "drive_0.db3 \n" + files + "  ros_distro: jazzy\n"};
  for (const std::string& metadata : told) {
    write_bytes(bag_folder_ + "/metadata.yaml", "rosbag2_bagfile_information:\n" + metadata);
    EXPECT_TRUE(all_of({bag_folder_}) == expected) << metadata;
  }
}

TEST_F(ReadRos2Folder, OfMoreFilesThanMayBeOpenIsRead) {
  const std::vector<Said> expected = all_of({bag_});
  const std::string split = folder_ / "split";
  std::filesystem::create_directory(split);
  for (std::size_t k = 0; k < messages_.size(); ++k) {
    const std::string number = std::to_string(1000 + k);
    if (k % 2 == 0) {
      write_db3(split + "/drive_" + number + ".db3", {messages_[k]});
    } else {
      write_bytes(split + "/drive_" + number + ".mcap", to_mcap({messages_[k]}));
    }
  }
  constexpr rlim_t kMostOpen = 30;
  ASSERT_GT(messages_.size(), kMostOpen);
  const FewOpenFiles lowered(kMostOpen);
  EXPECT_TRUE(all_of({split}) == expected);
}

TEST_F(ReadRos2Folder, SaysWhatIsWrong) {
  write_metadata("    - drive_2.db3\n");
  EXPECT_TRUE(contains(error_text<BagError>([&] { (void)all_of({bag_folder_}); }),
                       "has no file 'drive_2.db3', which its metadata.yaml names"));
  write_bytes(bag_folder_ + "/metadata.yaml", "a: [");
  EXPECT_TRUE(contains(error_text<BagError>([&] { (void)all_of({bag_folder_}); }),
                       "is no metadata of a bag of ROS 2"));
  EXPECT_TRUE(contains(error_text<ConfigurationError>([&] { (void)all_of({folder_.path()}); }),
                       "is a folder without a recording: it holds no metadata.yaml, .db3 or "
                       ".mcap of ROS 2"));
}

}  // namespace
}  // namespace matchbox_slam
