#include <gtest/gtest.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "bag/bag_reader.hpp"
#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/io/file.hpp"
#include "ros/messages.hpp"

namespace matchbox_slam {
namespace {

std::string why_not_opened(const std::string& path) {
  return error_text<BagError>([&] { const BagReader reader({path}); });
}

struct Count {
  int scans = 0;
  int transforms = 0;
  int static_transforms = 0;
  bool in_order = true;
  ros::Time first;
};

Count count(BagStream& stream) {
  Count counted;
  ros::Time last;
  while (const auto message = stream.next()) {
    if (const auto* transforms = std::get_if<BagTransforms>(&message->content)) {
      ++(transforms->is_static ? counted.static_transforms : counted.transforms);
    } else {
      ++counted.scans;
      counted.first = counted.first.isZero() ? message->time : counted.first;
    }
    counted.in_order = counted.in_order && message->time >= last;
    last = message->time;
  }
  return counted;
}

class ReadBag : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string path_ = folder_ / "small.bag";
};

TEST_F(ReadBag, StreamsScansAndTransformsInOrder) {
  write_small_bag(path_);
  const BagReader reader({path_});
  const auto stream = reader.stream({"/scan"}, {});
  const Count counted = count(*stream);
  EXPECT_EQ(counted.scans, 50);
  EXPECT_GT(counted.transforms, 100);
  EXPECT_TRUE(counted.in_order);
  EXPECT_EQ(reader.topics_of("sensor_msgs/LaserScan"), std::vector<std::string>{"/scan"});
}

TEST_F(ReadBag, ReadsEveryCompression) {
  for (const auto compression : {rosbag::compression::BZ2, rosbag::compression::LZ4}) {
    SmallBag recipe;
    recipe.compression = compression;
    write_small_bag(path_, recipe);
    EXPECT_EQ(count(*BagReader({path_}).stream({"/scan"}, {})).scans, 50);
  }
}

TEST_F(ReadBag, ReadsAPeriodAndTheStaticTransformsBefore) {
  write_small_bag(path_);
  {
    rosbag::Bag bag(path_, rosbag::bagmode::Append);
    bag.write("/tf_static", ros::Time(999.95), make_link(0.0, "base_link", "camera", 1.0));
  }
  const BagReader reader({path_});
  BagPeriod period;
  period.start = 2.05 - (1000.0 - reader.begin_time().toSec()) + 0.1;
  period.duration = 1.0;
  const Count counted = count(*reader.stream({"/scan"}, period));
  EXPECT_EQ(counted.scans, 10);
  EXPECT_EQ(counted.static_transforms, 1);
}

TEST_F(ReadBag, ReadsABagThatBeginsAtTimeZeroWithItsStaticTransforms) {
  {
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    bag.write("/tf_static", ros::Time(0, 1), make_link(0.0, "base_link", "laser", 1.0));
    bag.write("/scan", ros::Time(0, 1), make_scan(0.0, "laser"));
    bag.write("/scan", ros::Time(1.0), make_scan(1.0, "laser"));
  }
  const BagReader reader({path_});
  const Count all = count(*reader.stream({"/scan"}, {}));
  EXPECT_EQ(all.scans, 2);
  EXPECT_EQ(all.static_transforms, 1);
  BagPeriod later;
  later.start = 0.5;
  const Count counted = count(*reader.stream({"/scan"}, later));
  EXPECT_EQ(counted.scans, 1);
  EXPECT_EQ(counted.static_transforms, 1);
}

TEST_F(ReadBag, OfOneTimeWhatTheFirstBagHoldsComesFirst) {
  SmallBag recipe;
  write_small_bag(path_, recipe);
  recipe.laser_frame = "other";
  write_small_bag(folder_ / "second.bag", recipe);
  const BagReader reader({path_, folder_ / "second.bag"});
  const auto stream = reader.stream({"/scan"}, {});
  std::vector<std::string> frames;
  while (const auto message = stream->next()) {
    if (const auto* scan = std::get_if<ScanMessage>(&message->content)) {
      frames.push_back(scan->scan->header.frame_id);
    }
  }
  ASSERT_EQ(frames.size(), 100U);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i], i % 2 == 0 ? "laser" : "other") << i;
  }
}

TEST_F(ReadBag, ReadsSeveralBagsAsOne) {
  write_small_bag(path_);
  SmallBag second;
  second.begin = 1005.0;
  write_small_bag(folder_ / "second.bag", second);
  const BagReader reader({folder_ / "second.bag", path_});
  const Count counted = count(*reader.stream({"/scan"}, {}));
  EXPECT_EQ(counted.scans, 100);
  EXPECT_TRUE(counted.in_order);
  EXPECT_EQ(counted.first, ros::Time(1000.0));
  EXPECT_TRUE(contains(error_text<ConfigurationError>([&] {
                         const BagReader twice({path_, path_});
                       }),
                       "named twice"));
}

TEST_F(ReadBag, ReadingAheadGivesTheSameMessages) {
  write_small_bag(path_);
  const BagReader reader({path_});
  const auto plain = reader.stream({"/scan"}, {});
  std::vector<ros::Time> times;
  while (const auto message = plain->next()) {
    times.push_back(message->time);
  }
  const auto ahead = read_ahead(reader.stream({"/scan"}, {}), 3);
  for (const ros::Time& time : times) {
    const auto message = ahead->next();
    ASSERT_TRUE(message);
    EXPECT_EQ(message->time, time);
  }
  EXPECT_FALSE(ahead->next());
}

TEST_F(ReadBag, ReadingAheadMayBeLeftInTheMiddle) {
  write_small_bag(path_);
  const BagReader reader({path_});
  const auto ahead = read_ahead(reader.stream({"/scan"}, {}), 3);
  EXPECT_TRUE(ahead->next());
}

TEST_F(ReadBag, RefusesWhatIsNoBag) {
  EXPECT_EQ(error_text<ConfigurationError>([&] { const BagReader reader({path_}); }),
            "bag '" + path_ + "' does not exist");
  EXPECT_TRUE(
      contains(error_text<ConfigurationError>([&] { const BagReader reader({folder_.path()}); }),
               "is a folder"));
  replace_file(path_, "");
  EXPECT_EQ(why_not_opened(path_), "bag '" + path_ + "' is empty (0 bytes)");
  replace_file(path_, "a text, and no bag at all, but long enough to be taken for one\n");
  EXPECT_TRUE(contains(why_not_opened(path_), "is no bag of version 2.0"));
  { rosbag::Bag bag(path_, rosbag::bagmode::Write); }
  EXPECT_EQ(why_not_opened(path_), "bag '" + path_ + "' holds no messages");
}

TEST_F(ReadBag, RefusesABagWithoutIndex) {
  write_small_bag(path_);
  std::string bytes = read_file(path_);
  // The header of a bag whose recorder was killed: index_pos is still 0.
  const std::size_t place = bytes.find("index_pos=");
  ASSERT_NE(place, std::string::npos);
  bytes.replace(place + 10, 8, std::string(8, '\0'));
  replace_file(path_, bytes);
  const std::string text = why_not_opened(path_);
  EXPECT_TRUE(contains(text, "has no index")) << text;
  EXPECT_TRUE(contains(text, "rosbag reindex")) << text;
}

TEST_F(ReadBag, ABagCutOffAnywhereIsAnErrorAndNoCrash) {
  SmallBag recipe;
  recipe.scans = 5;
  write_small_bag(path_, recipe);
  const std::string bytes = read_file(path_);
  for (std::size_t size = 1; size < bytes.size(); size += 997) {
    replace_file(path_, bytes.substr(0, size));
    try {
      const BagReader reader({path_});
      (void)count(*reader.stream({"/scan"}, {}));
      ADD_FAILURE() << "a bag of " << size << " bytes of " << bytes.size() << " was read";
    } catch (const BagError& error) {
      EXPECT_TRUE(contains(error.what(), path_)) << error.what();
    }
  }
}

TEST_F(ReadBag, ADamagedChunkEndsTheStreamWithAnError) {
  SmallBag recipe;
  recipe.compression = rosbag::compression::BZ2;
  write_small_bag(path_, recipe);
  std::string bytes = read_file(path_);
  const std::size_t chunk = bytes.find("BZh");
  ASSERT_NE(chunk, std::string::npos);
  bytes.replace(chunk + 200, 64, std::string(64, 'x'));
  replace_file(path_, bytes);
  EXPECT_TRUE(contains(error_text<BagError>([&] {
                         const BagReader reader({path_});
                         (void)count(*reader.stream({"/scan"}, {}));
                       }),
                       "damaged"));
}

TEST_F(ReadBag, ReadsTransformsOfTheTypeBeforeTf2) {
  {
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    const auto header = boost::make_shared<ros::M_string>();
    (*header)["type"] = "tf/tfMessage";
    (*header)["md5sum"] = ros::message_traits::md5sum<tf2_msgs::TFMessage>();
    (*header)["message_definition"] = ros::message_traits::definition<tf2_msgs::TFMessage>();
    bag.write("/tf", ros::Time(1000.0), make_link(1000.0, "/odom", "/base", 1.0), header);
    bag.write("/scan", ros::Time(1000.0), make_scan(1000.0));
  }
  const BagReader reader({path_});
  EXPECT_EQ(reader.topics().at(1).type, "tf/tfMessage");
  EXPECT_EQ(count(*reader.stream({"/scan"}, {})).transforms, 1);
}

/// The bytes of a bag in which the offset of the index's first entry is another one.
std::string with_first_offset(std::string bytes, std::uint32_t offset) {
  // An index record's data: its length, then time (8 bytes) and offset of each entry.
  const std::size_t header = bytes.find("op=\x04");
  const std::size_t data = bytes.find("ver=", header);
  const std::size_t end = std::max(bytes.find("conn=", header), data) + 8;
  std::memcpy(&bytes[end + 1 + 4 + 8], &offset, sizeof(offset));
  return bytes;
}

TEST_F(ReadBag, AnIndexThatPointsBesideItsMessageIsAnErrorAndNoCrash) {
  for (const auto compression :
       {rosbag::compression::Uncompressed, rosbag::compression::BZ2, rosbag::compression::LZ4}) {
    SmallBag recipe;
    recipe.scans = 3;
    recipe.compression = compression;
    write_small_bag(path_, recipe);
    const std::string bytes = read_file(path_);
    for (const std::uint32_t offset : {1U, 500U, 0x7fffffffU, 0xffffffffU}) {
      replace_file(path_, with_first_offset(bytes, offset));
      const std::string text = error_text<BagError>([&] {
        const BagReader reader({path_});
        (void)count(*reader.stream({"/scan"}, {}));
      });
      EXPECT_TRUE(contains(text, "is damaged at byte")) << offset << ": " << text;
      EXPECT_TRUE(contains(text, "rosbag reindex")) << offset << ": " << text;
    }
  }
}

TEST_F(ReadBag, AMessageThatSaysItIsLargerThanItIsTakesNoMemory) {
  write_small_bag(path_);
  std::string bytes = read_file(path_);
  // The count of ranges follows the last of the seven numbers, range_max.
  const float range_max = make_scan(1.0).range_max;
  const std::string pattern(reinterpret_cast<const char*>(&range_max), sizeof(range_max));
  const std::size_t place = bytes.find(pattern + "Z");  // 90 beams
  ASSERT_NE(place, std::string::npos);
  bytes.replace(place + 4, 4, "\xff\xff\xff\xff");
  replace_file(path_, bytes);
  const std::string text =
      error_text<BagError>([&] { (void)count(*BagReader({path_}).stream({"/scan"}, {})); });
  EXPECT_TRUE(contains(text, "4294967295 elements of 4 bytes are announced")) << text;
}

}  // namespace
}  // namespace matchbox_slam
