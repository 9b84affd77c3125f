#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <cstring>

#include "bag/bag_error.hpp"
#include "bag/cdr_message.hpp"
#include "bag/cdr_writer.hpp"
#include "common/error_text.hpp"

namespace matchbox_slam {
namespace {

std::string bytes_of(const std::vector<int>& values) {
  std::string bytes;
  for (const int value : values) {
    bytes += static_cast<char>(value);
  }
  return bytes;
}

MessageContent read(const std::string& bytes, const std::string& type) {
  BagConnection connection;
  connection.topic = "/topic";
  connection.type = type;
  // Bytes are characters here. NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  return read_cdr_message({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()},
                          connection);
}

template <typename Message>
Message read_as(const std::string& bytes) {
  return *std::get<boost::shared_ptr<const Message>>(
      read(bytes, ros::message_traits::datatype<Message>()));
}

// By the rules of OMG's "DDS Interoperability Wire Protocol" and "Extensible Types": the header of
// four bytes, each primitive aligned to its size from there on, text with its length and a zero.

TEST(CdrMessage, ReadsTheBytesOfALaserScanInEitherOrder) {
  const std::string little = bytes_of({
      0x00, 0x01, 0x00, 0x00,                          // little-endian
      0x05, 0x00, 0x00, 0x00, 0x07, 0x00, 0x00, 0x00,  // 5 s, 7 ns
      0x03, 0x00, 0x00, 0x00, 'a',  'b',  0x00, 0x00,  // "ab", and padding
      0x00, 0x00, 0x80, 0xBF,                          // -1
      0x00, 0x00, 0x80, 0x3F,                          // 1
      0x00, 0x00, 0x00, 0x3F,                          // 0.5
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // 0, 0
      0x00, 0x00, 0x80, 0x3E,                          // 0.25
      0x00, 0x00, 0x20, 0x41,                          // 10
      0x02, 0x00, 0x00, 0x00,                          // two ranges
      0x00, 0x00, 0x00, 0x40, 0x00, 0x00, 0x40, 0x40,  // 2, 3
      0x00, 0x00, 0x00, 0x00                           // no intensities
  });
  const std::string big = bytes_of({
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x05, 0x00, 0x00, 0x00, 0x07, 0x00,
      0x00, 0x00, 0x03, 'a',  'b',  0x00, 0x00, 0xBF, 0x80, 0x00, 0x00, 0x3F, 0x80,
      0x00, 0x00, 0x3F, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
      0x00, 0x3E, 0x80, 0x00, 0x00, 0x41, 0x20, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02,
      0x40, 0x00, 0x00, 0x00, 0x40, 0x40, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
  });
  for (const std::string& bytes : {little, big}) {
    const auto scan = read_as<sensor_msgs::LaserScan>(bytes);
    EXPECT_EQ(scan.header.stamp, ros::Time(5, 7));
    EXPECT_EQ(scan.header.frame_id, "ab");
    EXPECT_EQ(scan.angle_min, -1.0F);
    EXPECT_EQ(scan.angle_max, 1.0F);
    EXPECT_EQ(scan.angle_increment, 0.5F);
    EXPECT_EQ(scan.range_min, 0.25F);
    EXPECT_EQ(scan.range_max, 10.0F);
    EXPECT_EQ(scan.ranges, (std::vector<float>{2.0F, 3.0F}));
    EXPECT_TRUE(scan.intensities.empty());
  }
}

TEST(CdrMessage, AlignsDoublesToEightBytesAfterText) {
  std::string bytes = bytes_of({
      0x00, 0x01, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00,  // one transform
      0x05, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // its stamp
      0x02, 0x00, 0x00, 0x00, 'o',  0x00, 0x00, 0x00,  // "o", and padding
      0x02, 0x00, 0x00, 0x00, 'b',  0x00,              // "b"
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00,              // up to 32 after the header
  });
  for (const double value : {1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0}) {
    std::string raw(sizeof(double), '\0');
    std::memcpy(raw.data(), &value, sizeof(double));
    bytes += raw;
  }
  const auto message = read_as<tf2_msgs::TFMessage>(bytes);
  ASSERT_EQ(message.transforms.size(), 1U);
  EXPECT_EQ(message.transforms[0].child_frame_id, "b");
  EXPECT_EQ(message.transforms[0].transform.translation.y, 2.0);
  EXPECT_EQ(message.transforms[0].transform.rotation.w, 1.0);
}

TEST(CdrMessage, CutOffAnywhereItIsAnErrorThatTakesNoMemory) {
  auto scan = boost::make_shared<sensor_msgs::LaserScan>();
  scan->header.frame_id = "laser";
  scan->ranges.assign(100, 1.0F);
  const std::string bytes = to_cdr(sensor_msgs::LaserScan::ConstPtr(scan));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_TRUE(contains(
        error_text<ByteError>([&] { (void)read(bytes.substr(0, size), "sensor_msgs/LaserScan"); }),
        "are announced where"))
        << size;
  }
  std::string lying = bytes;
  const std::size_t count = lying.find("\x64\0\0\0", 0, 4);
  lying.replace(count, 4, "\xff\xff\xff\xff");
  EXPECT_EQ(error_text<ByteError>([&] { (void)read(lying, "sensor_msgs/LaserScan"); }),
            "4294967295 elements of 4 bytes are announced where 404 bytes are left");
}

TEST(CdrMessage, SaysWhatIsWrong) {
  const auto why = [](std::vector<int> bytes) {
    return error_text<ByteError>([&] { (void)read(bytes_of(bytes), "sensor_msgs/LaserScan"); });
  };
  EXPECT_EQ(why({0x00, 0x07, 0x00, 0x00}),
            "it is not in plain CDR: it begins with the bytes 0 and 7; allowed: 0, then 0 or 1");
  EXPECT_EQ(why({0x00, 0x01, 0x00, 0x00, 0xff, 0xff, 0xff, 0xff, 0x00, 0x00, 0x00, 0x00}),
            "a stamp is -1 s and 0 ns");
  EXPECT_EQ(error_text<BagError>([] { (void)read(std::string(4, '\0'), "std_msgs/String"); }),
            "topic /topic of the bag holds std_msgs/String, which is not read");
  EXPECT_EQ(ros1_type("tf2_msgs/msg/TFMessage"), "tf2_msgs/TFMessage");
}

}  // namespace
}  // namespace matchbox_slam
