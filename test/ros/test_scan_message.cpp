#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "common/error_text.hpp"
#include "ros/message_conversion.hpp"
#include "ros/messages.hpp"
#include "ros/scan_message.hpp"
#include "ros/scan_queue.hpp"
#include "ros/scan_types.hpp"

namespace matchbox_slam {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TEST(MultiEcho, TheFirstEchoOfEachBeamCounts) {
  const sensor_msgs::LaserScan scan = make_scan(12.5);
  sensor_msgs::MultiEchoLaserScan message = to_multi_echo(scan);
  message.ranges[7].echoes.clear();
  const ScanMessage read = to_scan(message);
  EXPECT_EQ(read.defect, "");
  EXPECT_EQ(read.scan->header.stamp, scan.header.stamp);
  EXPECT_EQ(read.scan->header.frame_id, "laser");
  EXPECT_EQ(read.scan->angle_min, scan.angle_min);
  EXPECT_EQ(read.scan->angle_increment, scan.angle_increment);
  EXPECT_EQ(read.scan->range_max, scan.range_max);
  ASSERT_EQ(read.scan->ranges.size(), scan.ranges.size());
  for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
    EXPECT_TRUE(k == 7 ? std::isnan(read.scan->ranges[k]) : read.scan->ranges[k] == scan.ranges[k])
        << k;
  }
}

std_msgs::Header header() { return make_scan(12.5).header; }

/// Four beams: ahead, left, back and right.
CloudOptions four_beams() {
  CloudOptions options;
  options.angle_min = 0.0;
  options.angle_max = 1.5 * kPi;
  options.angle_increment = 0.5 * kPi;
  return options;
}

/// Ranges of the four beams, -1 where nothing is known.
std::vector<float> four_ranges(const std::vector<CloudPoint>& points,
                               const CloudOptions& options = four_beams()) {
  const ScanMessage read = to_scan(make_cloud(header(), points), options);
  EXPECT_EQ(read.defect, "");
  std::vector<float> ranges = read.scan->ranges;
  for (float& range : ranges) {
    range = std::isnan(range) ? -1.0F : range;
  }
  return ranges;
}

using Ranges = std::vector<float>;

TEST(Cloud, TheNearestPointOfEachBeamCounts) {
  EXPECT_EQ(four_ranges({{4.0F, 0.0F}, {3.0F, 0.0F}, {0.0F, 5.0F}, {-2.0F, 0.1F}, {-3.0F, -4.0F}}),
            (Ranges{3.0F, 5.0F, std::hypot(2.0F, 0.1F), 5.0F}));
  EXPECT_EQ(four_ranges({{4.0F, -0.1F}, {kNan, 1.0F}, {1.0F, kNan}, {0.05F, 0.0F}, {0.0F, 100.0F}}),
            (Ranges{std::hypot(4.0F, 0.1F), -1.0F, -1.0F, -1.0F}))
      << "no numbers, or out of reach";
  CloudOptions clearing = four_beams();
  clearing.clear_empty = true;
  const float free = std::numeric_limits<float>::infinity();
  EXPECT_EQ(four_ranges({{4.0F, 0.0F}, {0.0F, 0.05F}, {0.0F, 100.0F}, {-100.0F, 0.0F}}, clearing),
            (Ranges{4.0F, -1.0F, free, free}))
      << "too near hides what is behind it; too far is no return, as nothing is";
}

TEST(Cloud, TakesABandOfHeightsOrARing) {
  const std::vector<CloudPoint> points = {{1.0F, 0.0F, -0.3F, 1},
                                          {2.0F, 0.0F, -0.2F, 2},
                                          {0.0F, 3.0F, 0.2F, 3},
                                          {-4.0F, 0.0F, kNan, 3},
                                          {0.0F, -5.0F, 0.3F, 3}};
  CloudOptions options = four_beams();
  options.min_height = static_cast<double>(-0.2F);
  options.max_height = static_cast<double>(0.2F);
  EXPECT_EQ(four_ranges(points, options), (Ranges{2.0F, 3.0F, -1.0F, -1.0F}));
  options.ring = 3;
  EXPECT_EQ(four_ranges(points, options), (Ranges{-1.0F, 3.0F, 4.0F, 5.0F}));
}

TEST(Cloud, ReadsRowsFieldsAndNumbersOfAnyKind) {
  PointCloud2 cloud;
  cloud.header = header();
  add_field(cloud, "intensity", 0, PointField::FLOAT32);
  add_field(cloud, "y", 4, PointField::FLOAT64);
  add_field(cloud, "x", 12, PointField::FLOAT64);
  add_field(cloud, "ring", 20, PointField::INT8);
  cloud.point_step = 21;
  cloud.width = 1;
  cloud.height = 2;
  cloud.row_step = 30;
  cloud.data.resize(60);
  for (std::size_t row = 0; row < 2; ++row) {
    const double y = row == 0 ? 2.0 : -3.0;
    std::memcpy(&cloud.data[30 * row + 4], &y, sizeof(double));
    cloud.data[30 * row + 20] = 5;
  }
  CloudOptions options = four_beams();
  options.ring = 5;
  const ScanMessage read = to_scan(cloud, options);
  EXPECT_EQ(read.defect, "");
  ASSERT_EQ(read.scan->ranges.size(), 4U);
  EXPECT_EQ(read.scan->ranges[1], 2.0F);
  EXPECT_EQ(read.scan->ranges[3], 3.0F);
}

TEST(Cloud, TellsWhereItsBeamsPointAndWhenTheyWereTaken) {
  const PointCloud2 cloud = make_cloud(header(), {{0.0F, 2.0F}});
  CloudOptions options = four_beams();
  options.scan_time = 0.3;
  const sensor_msgs::LaserScan scan = *to_scan(cloud, options).scan;
  EXPECT_EQ(find_defect(scan), "");
  EXPECT_EQ(scan.header.stamp, ros::Time(12.5));
  EXPECT_FLOAT_EQ(scan.angle_min, 0.0F);
  EXPECT_FLOAT_EQ(scan.angle_max, static_cast<float>(1.5 * kPi));
  EXPECT_FLOAT_EQ(scan.angle_increment, static_cast<float>(0.5 * kPi));
  EXPECT_FLOAT_EQ(scan.time_increment, 0.1F);
  options.scan_time = -0.3;
  const sensor_msgs::LaserScan clockwise = *to_scan(cloud, options).scan;
  EXPECT_EQ(find_defect(clockwise), "");
  EXPECT_FLOAT_EQ(clockwise.angle_min, static_cast<float>(1.5 * kPi));
  EXPECT_FLOAT_EQ(clockwise.angle_increment, static_cast<float>(-0.5 * kPi));
  EXPECT_FLOAT_EQ(clockwise.time_increment, 0.1F);
  EXPECT_EQ(clockwise.ranges[2], 2.0F);
}

TEST(Cloud, ATurnHasNoBeamTwice) {
  const ScanMessage read = to_scan(make_cloud(header(), {{-2.0F, 0.0F}, {-3.0F, -0.0F}}), {});
  ASSERT_EQ(read.scan->ranges.size(), 1440U);
  EXPECT_EQ(read.scan->ranges[0], 2.0F);
  EXPECT_TRUE(std::isnan(read.scan->ranges[1439]));
  EXPECT_EQ(find_defect(*read.scan), "");
}

TEST(Cloud, OfAScanGivesTheScanBack) {
  const sensor_msgs::LaserScan scan = make_scan(12.5);
  CloudOptions options;
  options.angle_min = static_cast<double>(scan.angle_min);
  options.angle_increment = static_cast<double>(scan.angle_increment);
  options.angle_max = options.angle_min + 89.0 * options.angle_increment;
  options.range_max = 30.0;
  for (const int ring : {-1, 3}) {
    options.ring = ring;
    const ScanMessage read = to_scan(to_cloud(scan), options);
    EXPECT_EQ(read.scan->angle_min, scan.angle_min);
    EXPECT_EQ(read.scan->angle_increment, scan.angle_increment);
    ASSERT_EQ(read.scan->ranges.size(), scan.ranges.size());
    for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
      EXPECT_NEAR(read.scan->ranges[k], scan.ranges[k], 1e-6) << k;
    }
  }
}

/// What is said of a cloud after something was done to it.
std::string defect_of(const std::function<void(PointCloud2&)>& damage,
                      const CloudOptions& options = {}) {
  PointCloud2 cloud = make_cloud(header(), {{1.0F, 2.0F}, {2.0F, 1.0F}, {3.0F, 1.0F}}, 3);
  damage(cloud);
  const ScanMessage read = to_scan(cloud, options);
  EXPECT_EQ(read.scan->header.frame_id, "laser");
  EXPECT_EQ(read.scan->ranges.empty(), !read.defect.empty());
  return read.defect;
}

TEST(Cloud, SaysWhatIsWrongAndWhatToDo) {
  EXPECT_EQ(defect_of([](PointCloud2& /*cloud*/) {}), "");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.fields[0].name = "range"; }),
            "its points have no field x; they have: range, y, z, ring");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.fields.resize(2); }),
            "its points have no field z; they have: x, y");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.fields.clear(); }),
            "its points have no field z; they have: none");
  CloudOptions by_ring;
  by_ring.ring = 1;
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.fields.resize(3); }, by_ring),
            "its points have no field ring; they have: x, y, z; to take a band of heights leave "
            "cloud/ring out");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.fields[1].datatype = PointField::INT32; }),
            "its field y has the datatype 5 (INT32); allowed: 7 (FLOAT32), 8 (FLOAT64)");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.fields[1].datatype = 99; }),
            "its field y has the datatype 99; allowed: 7 (FLOAT32), 8 (FLOAT64)");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.fields[3].datatype = PointField::FLOAT32; },
                      by_ring),
            "its field ring has the datatype 7 (FLOAT32); allowed: 1 to 6, whole numbers");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.is_bigendian = 1; }),
            "it is big-endian (is_bigendian 1); allowed: 0; let its driver, or a node between, "
            "send it little-endian, as this computer has it");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.data.pop_back(); }),
            "its data has 71 bytes; height x row_step, 3 x 24, are 72");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.height = 4000000000U; }),
            "its data has 72 bytes; height x row_step, 4000000000 x 24, are 96000000000");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.row_step = 20; }),
            "its row_step 20 is too short for its width 1 of points of point_step 24");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.point_step = 8; }),
            "its field z ends at byte 12 of a point; its point_step is 8");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.fields[0].offset = 4294967295U; }),
            "its field x ends at byte 4294967299 of a point; its point_step is 24");
}

TEST(Cloud, SaysWhyNothingIsLeftOfIt) {
  EXPECT_EQ(defect_of([](PointCloud2& cloud) { cloud.width = 0; }), "it has no points");
  EXPECT_EQ(defect_of([](PointCloud2& cloud) {
              cloud.height = 4000000000U;
              cloud.width = cloud.row_step = 0;
            }),
            "it has no points");
  const std::vector<CloudPoint> points = {
      {kNan, 0.0F}, {0.01F, 0.0F}, {200.0F, 0.0F}, {2.0F, 0.0F, 1.0F}};
  const ScanMessage read = to_scan(make_cloud(header(), points), {});
  EXPECT_TRUE(read.is_empty);
  EXPECT_EQ(read.defect,
            "none of its 4 points is left: 1 are no numbers, 1 not between cloud/min_height -0.2 "
            "and cloud/max_height 0.2 m, 2 outside of cloud/range_min to range_max or of "
            "cloud/angle_min to angle_max");
  CloudOptions options;
  options.clear_empty = true;
  EXPECT_EQ(to_scan(make_cloud(header(), points), options).defect, "") << "nothing is seen";
}

TEST(Cloud, WithADefectIsCountedAsSkipped) {
  ScanQueueSettings settings;
  settings.base_frame = "laser";
  ScanQueue queue(settings);
  PointCloud2 cloud = make_cloud(header(), {{1.0F, 2.0F}});
  queue.add_scan(to_scan(cloud, {}), ros::Time(12.6));
  cloud.header.stamp = ros::Time(12.6);
  cloud.is_bigendian = 1;
  queue.add_scan(to_scan(cloud, {}), ros::Time(12.7));
  cloud.width = 0;
  queue.add_scan(to_scan(cloud, {}), ros::Time(12.8));
  EXPECT_TRUE(queue.next());
  EXPECT_EQ(to_string(queue.account()),
            "3 scans received, 1 used, 2 skipped (invalid: 1, empty: 1)");
  EXPECT_TRUE(contains(queue.take_skipped().front().text,
                       "scan of 12.600 s skipped (invalid): it is big-endian"));
}

}  // namespace
}  // namespace matchbox_slam
