#include <gtest/gtest.h>

#include <boost/make_shared.hpp>

#include "bag/bag_error.hpp"
#include "bag/mcap_file.hpp"
#include "bag/ros2_recordings.hpp"
#include "bag/ros2_test.hpp"
#include "common/error_text.hpp"

namespace matchbox_slam {
namespace {

class ReadMcap : public Ros2Test {
 protected:
  ReadMcap() : Ros2Test("whole.mcap") {}
};

TEST_F(ReadMcap, GivesTheMessagesOfABagInAnyKindOfFile) {
  const std::vector<Said> expected = all_of({bag_});
  ASSERT_GT(expected.size(), 70U);
  for (const std::string compression : {"", "lz4", "zstd"}) {
    for (const bool with_index : {true, false}) {
      for (const std::size_t chunk_messages : {0U, 1U, 7U, 1000U}) {
        McapRecipe recipe;
        recipe.compression = compression;
        recipe.with_index = with_index;
        recipe.with_summary = with_index;
        recipe.chunk_messages = chunk_messages;
        write_bytes(path_, to_mcap(messages_, recipe));
        EXPECT_TRUE(all_of({path_}) == expected)
            << compression << ' ' << with_index << ' ' << chunk_messages;
      }
    }
  }
  write_bytes(path_, to_mcap(as_ros2(bag_, false)));
  EXPECT_TRUE(all_of({path_}) == expected);
}

TEST_F(ReadMcap, ReadsMessagesThatArePackedOneByOne) {
  const std::vector<Said> expected = all_of({bag_});
  for (Ros2Message& message : messages_) {
    message.bytes = pack_zstd(message.bytes);
  }
  write_bytes(path_, to_mcap(messages_));
  EXPECT_TRUE(all_of({path_}) == expected);
}

TEST_F(ReadMcap, ReadsMessagesOfRos1) {
  const std::vector<Said> expected = all_of({bag_});
  const BagReader bag({bag_});
  std::vector<Ros2Message> messages;
  const auto stream = bag.messages([](const BagConnection& /*all*/) { return true; }, {});
  for (const Said& said : expected) {
    const BagConnection& connection = *stream->next()->connection;
    messages.push_back(
        {said.topic, connection.type, said.time.toNSec(), said.bytes, connection.md5sum});
  }
  McapRecipe recipe;
  recipe.encoding = "ros1";
  write_bytes(path_, to_mcap(messages, recipe));
  EXPECT_TRUE(all_of({path_}) == expected);
  messages.front().md5sum = "0";
  write_bytes(path_, to_mcap(messages, recipe));
  EXPECT_TRUE(contains(error_text<BagError>([&] { (void)all_of({path_}); }),
                       "in a definition that is not the one of"));
}

TEST_F(ReadMcap, TellsItsTopicsWithTheTypesOfRos1) {
  write_bytes(path_, to_mcap(messages_));
  const BagReader reader({path_});
  const BagReader bag({bag_});
  ASSERT_EQ(reader.topics().size(), bag.topics().size());
  for (std::size_t k = 0; k < bag.topics().size(); ++k) {
    EXPECT_EQ(reader.topics()[k].name, bag.topics()[k].name);
    EXPECT_EQ(reader.topics()[k].type, bag.topics()[k].type);
    EXPECT_EQ(reader.topics()[k].messages, bag.topics()[k].messages);
  }
  EXPECT_EQ(reader.begin_time(), bag.begin_time());
  EXPECT_EQ(reader.end_time(), bag.end_time());
}

TEST_F(ReadMcap, MessagesOutOfOrderComeInTheOrderOfTime) {
  const std::vector<Said> expected = all_of({bag_});
  std::vector<Ros2Message> mixed = messages_;
  for (std::size_t k = 0; k + 11 < mixed.size(); k += 11) {
    if (mixed[k].time != mixed[k + 10].time) {
      std::swap(mixed[k], mixed[k + 10]);
    }
  }
  McapRecipe recipe;
  recipe.chunk_messages = 7;
  write_bytes(path_, to_mcap(mixed, recipe));
  const std::vector<Said> read = all_of({path_});
  ASSERT_EQ(read.size(), expected.size());
  for (std::size_t k = 0; k < read.size(); ++k) {
    EXPECT_EQ(read[k].time, expected[k].time) << k;
  }
}

TEST_F(ReadMcap, CutOffAnywhereItIsReadAsFarAsItGoes) {
  const std::vector<Said> expected = all_of({bag_});
  for (const std::string compression : {"", "lz4", "zstd"}) {
    for (const std::size_t chunk_messages : {0U, 20U}) {
      McapRecipe recipe;
      recipe.compression = compression;
      recipe.chunk_messages = chunk_messages;
      const std::string bytes = to_mcap(messages_, recipe);
      std::size_t most = 0;
      for (std::size_t size = 0; size < bytes.size(); size += 397) {
        write_bytes(path_, bytes.substr(0, size));
        std::vector<Said> read;
        std::string damage;
        try {
          read = all_of({path_}, &damage);
        } catch (const BagError& error) {
          damage = error.what();
        }
        EXPECT_GE(read.size(), most) << size;
        most = read.size();
        EXPECT_TRUE(std::equal(read.begin(), read.end(), expected.begin())) << size;
        EXPECT_TRUE(contains(damage, path_) || read.size() == expected.size()) << size << damage;
      }
      EXPECT_EQ(most, expected.size());
    }
  }
}

TEST_F(ReadMcap, ADamagedChunkEndsItWithAnErrorThatTellsWhatToDo) {
  const std::vector<Said> expected = all_of({bag_});
  for (const std::string compression : {"", "lz4", "zstd"}) {
    McapRecipe recipe;
    recipe.compression = compression;
    recipe.chunk_messages = 10;
    std::string bytes = to_mcap(messages_, recipe);
    write_bytes(path_, bytes);
    const McapChunk chunk = McapFile(path_).chunks().at(3);
    bytes[chunk.position + chunk.size / 2] ^= 0x10;
    write_bytes(path_, bytes);
    std::string damage;
    const std::vector<Said> read = all_of({path_}, &damage);
    EXPECT_GE(read.size(), 20U) << compression;
    EXPECT_LE(read.size(), 40U) << compression;
    EXPECT_TRUE(std::equal(read.begin(), read.end(), expected.begin())) << compression;
    EXPECT_TRUE(contains(damage, "is damaged at byte ")) << damage;
    EXPECT_TRUE(contains(damage, "mcap recover '" + path_ + "' -o NEW.mcap")) << damage;
  }
}

TEST_F(ReadMcap, SaysWhatItCannotRead) {
  McapRecipe recipe;
  recipe.encoding = "json";
  write_bytes(path_, to_mcap(messages_, recipe));
  EXPECT_TRUE(contains(error_text<BagError>([&] { (void)all_of({path_}); }),
                       "has messages in the encoding 'json'; allowed: cdr or ros1"));
  write_bytes(path_, "\x89MCAP0\r\n");
  EXPECT_TRUE(contains(error_text<BagError>([&] { (void)all_of({path_}); }),
                       "is damaged at byte 8 (it ends without its end)"));
  write_bytes(path_, McapWriter({}).finish());
  EXPECT_EQ(error_text<BagError>([&] { (void)all_of({path_}); }),
            "bag '" + path_ + "' holds no messages");
}

/// Bytes as the specification has them: header, schema, channel and message, in no chunk.
TEST_F(ReadMcap, ReadsTheBytesOfTheSpecification) {
  using namespace std::string_literals;
  const auto imu = boost::make_shared<sensor_msgs::Imu>();
  imu->orientation.w = 0.5;
  const std::string cdr = to_cdr(sensor_msgs::Imu::ConstPtr(imu));
  const std::string message_size{static_cast<char>(22 + cdr.size()), '\x01'};
  ASSERT_EQ(22 + cdr.size(), 256U + static_cast<unsigned char>(message_size[0]));
  const std::string bytes =
      "\x89MCAP\x30\r\n"s
      "\x01\x08\0\0\0\0\0\0\0"
      "\0\0\0\0"
      "\0\0\0\0"s  // header
      "\x03\x1D\0\0\0\0\0\0\0"
      "\x01\0"
      "\x13\0\0\0sensor_msgs/msg/Imu"s  // schema
      "\0\0\0\0"s
      "\x04\x17\0\0\0\0\0\0\0"
      "\x02\0"
      "\x01\0"
      "\x04\0\0\0/imu"
      "\x03\0\0\0"
      "cdr"s  // channel
      "\0\0\0\0"s +
      "\x05"s + message_size +
      "\0\0\0\0\0\0"s  // message
      "\x02\0"
      "\x01\0\0\0"
      "\0\xCA\x9A\x3B\0\0\0\0"
      "\x01\x02\x03\x04\x05\x06\x07\x08"s +
      cdr +
      "\x0F\x04\0\0\0\0\0\0\0"
      "\0\0\0\0"s;  // data end
  write_bytes(path_, bytes);
  const std::vector<Said> read = all_of({path_});
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].topic, "/imu");
  EXPECT_EQ(read[0].time, ros::Time(1, 0));
  const BagReader reader({path_});
  const auto stream = reader.messages([](const BagConnection& /*all*/) { return true; }, {});
  EXPECT_EQ(std::get<sensor_msgs::Imu::ConstPtr>(stream->next()->content)->orientation.w, 0.5);
}

}  // namespace
}  // namespace matchbox_slam
