#include <gtest/gtest.h>

#include <cmath>

#include "bag/carmen_line.hpp"
#include "common/error_text.hpp"
#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

CarmenScan scan_in(const std::string& line) {
  return std::get<CarmenScan>(parse_carmen_line(line).content);
}

std::string why_bad(const std::string& line) {
  return error_text<CarmenLineError>([&] { (void)parse_carmen_line(line); });
}

TEST(CarmenLine, ReadsAFlaser) {
  const std::string text =
      "FLASER 3 1.25 81.91 0.5 1.0 2.0 0.5 0.9 2.0 0.4 976052857.345678 nohost 12.5";
  const CarmenLine line = parse_carmen_line(text);
  const CarmenScan scan = scan_in(text);
  EXPECT_EQ(scan.message, "FLASER");
  EXPECT_EQ(scan.ranges, (std::vector<float>{1.25F, 81.91F, 0.5F}));
  EXPECT_EQ(scan.laser, (Pose2{1.0, 2.0, 0.5}));
  EXPECT_EQ(scan.robot, (Pose2{0.9, 2.0, 0.4}));
  EXPECT_EQ(scan.maximum_range, 80.0);
  EXPECT_FALSE(scan.tells_angles);
  EXPECT_DOUBLE_EQ(line.ipc_stamp.value(), 976052857.345678);
  EXPECT_DOUBLE_EQ(line.logger_stamp.value(), 12.5);
}

/// A FLASER of so many beams.
std::string flaser(std::size_t beams) {
  std::string line = "FLASER " + std::to_string(beams);
  for (std::size_t k = 0; k < beams; ++k) {
    line += " 1";
  }
  return line + " 0 0 0 0 0 0";
}

TEST(CarmenLine, TakesTheAnglesThatCarmenTakesForSoManyBeams) {
  const double degree = kPi / 180.0;
  for (const auto& [beams, increment] :
       {std::pair(180, degree), std::pair(181, degree), std::pair(360, 0.5 * degree),
        std::pair(361, 0.5 * degree), std::pair(400, 0.25 * degree), std::pair(401, 0.25 * degree),
        std::pair(91, 2.0 * degree)}) {
    const CarmenScan scan = scan_in(flaser(static_cast<std::size_t>(beams)));
    EXPECT_DOUBLE_EQ(scan.start_angle, -0.5 * kPi) << beams;
    EXPECT_DOUBLE_EQ(scan.increment, increment) << beams;
  }
}

TEST(CarmenLine, ReadsARobotlaserWithRemissionsAndWithout) {
  const std::string config = " 0 -1.570796 3.141593 0.017453 81.9 0.01 0 2 1.5 2.5 ";
  const std::string body = "1 2 0.5 0.75 2 0.5 0 0 0.1 0.2";
  const std::string tail = " 1.5 host 0.25";
  for (const std::string turn_axis : {" 0.3", ""}) {
    const CarmenScan old = scan_in("ROBOTLASER1" + config + body + turn_axis + tail);
    EXPECT_TRUE(old.remissions.empty());
    EXPECT_EQ(old.laser, (Pose2{1.0, 2.0, 0.5}));
    EXPECT_EQ(old.robot, (Pose2{0.75, 2.0, 0.5}));
  }
  const std::string text = "ROBOTLASER1" + config + "2 7 8 " + body + " 0.3" + tail;
  const CarmenScan scan = scan_in(text);
  EXPECT_TRUE(scan.tells_angles);
  EXPECT_DOUBLE_EQ(scan.start_angle, -1.570796);
  EXPECT_DOUBLE_EQ(scan.increment, 0.017453);
  EXPECT_EQ(scan.maximum_range, 80.0);  // 81.9 is what the laser says where there is nothing
  EXPECT_EQ(scan.ranges, (std::vector<float>{1.5F, 2.5F}));
  EXPECT_EQ(scan.remissions, (std::vector<float>{7.0F, 8.0F}));
  EXPECT_EQ(scan.robot, (Pose2{0.75, 2.0, 0.5}));
  EXPECT_EQ(parse_carmen_line(text).ipc_stamp, 1.5);
  // None of two beams, where the laser's x follows as a whole number.
  EXPECT_EQ(scan_in("ROBOTLASER1" + config + "0 " + body + " 0.3" + tail).laser->x, 1.0);
}

TEST(CarmenLine, ReadsARobotlaserWithRemissionsAndWithoutATurnAxis) {
  const std::string config = "ROBOTLASER1 0 -1.570796 3.141593 0.017453 81.9 0.01 0 2 1.5 2.5 ";
  const std::string body = "1.0 2.0 0.5 0.75 2.0 0.5 0.0 0.0 0.1 0.2";
  const std::string tail = " 1.5 host 0.25";
  for (const auto& [remissions, values] :
       {std::pair("2 7 8 ", std::vector<float>{7.0F, 8.0F}), std::pair("1 7 ", std::vector{7.0F}),
        std::pair("0 ", std::vector<float>{}), std::pair("", std::vector<float>{})}) {
    const CarmenScan scan = scan_in(config + remissions + body + tail);
    EXPECT_EQ(scan.remissions, values) << remissions;
    EXPECT_EQ(scan.laser, (Pose2{1.0, 2.0, 0.5})) << remissions;
    EXPECT_EQ(scan.robot, (Pose2{0.75, 2.0, 0.5})) << remissions;
    EXPECT_EQ(parse_carmen_line(config + remissions + body + tail).logger_stamp, 0.25);
  }
  // A robot at the beginning, in a log of another writer, which has an axis and no remissions.
  const CarmenScan at_origin = scan_in(config + "0 0 0.5 0 0 0.5 0 0 0.1 0.2 0.3" + tail);
  EXPECT_EQ(at_origin.laser, (Pose2{0.0, 0.0, 0.5}));
  EXPECT_EQ(at_origin.robot, (Pose2{0.0, 0.0, 0.5}));
}

TEST(CarmenLine, ReadsARawlaserOdometryAndParameters) {
  const CarmenScan raw = scan_in("RAWLASER2 2 -2.0 4.0 0 5.6 0 0 3 1 2 3 0 1.5 host 0.25");
  EXPECT_EQ(raw.message, "RAWLASER2");
  EXPECT_EQ(raw.increment, 2.0);  // the field of view over the beams
  EXPECT_EQ(raw.maximum_range, 5.6);
  EXPECT_FALSE(raw.robot);
  const CarmenLine odometry = parse_carmen_line("ODOM 1 2 -3.5 0.1 0.2 0 5.5 host 1.5");
  EXPECT_NEAR(std::get<CarmenOdometry>(odometry.content).robot.theta, 2.0 * kPi - 3.5, 1e-12);
  EXPECT_EQ(odometry.ipc_stamp, 5.5);
  const auto parameter = std::get<CarmenParameter>(
      parse_carmen_line("PARAM robot_frontlaser_offset 0.21 host 0").content);
  EXPECT_EQ(parameter.value, 0.21);
}

TEST(CarmenLine, PassesOverWhatItHasNoUseFor) {
  for (const std::string line : {"", "# FLASER num_readings", "SYNC tag 1 host 1", "NMEAGGA 1 2 3",
                                 "TRUEPOS 0 0 0 0 0 0 1 host 1", "VERTEX2 1 0.34 0.0005 -0.05",
                                 "EDGE2 0 1 0.34 0 0 50 0 50 100 0 0"}) {
    EXPECT_EQ(parse_carmen_line(line).content.index(), 0U) << line;
  }
}

TEST(CarmenLine, SaysWhatIsWrong) {
  EXPECT_EQ(why_bad("FLASER 3 1.0 2.0"),
            "3 words of readings should follow where 2 are left; it may be cut off");
  EXPECT_EQ(why_bad("FLASER 2 1.0 x 0 0 0 0 0 0"),
            "number 2 of readings is 'x', which is no number");
  EXPECT_EQ(why_bad("FLASER 1e9 1.0"), "the number of readings is '1e9'; allowed: 0 to 100000");
  EXPECT_EQ(why_bad("FLASER 1 1.0 0 0 0 0 nan 0"), "the robot's pose is 'nan', which is no number");
  EXPECT_EQ(why_bad("FLASR 1 1.0"), "'FLASR' is no message of CARMEN");
  EXPECT_EQ(why_bad("ODOM 1 2 3 0 0 0 -5 host 1"), "its stamp is before 1970 or after 2106");
  EXPECT_EQ(why_bad("PARAM robot_frontlaser_offset x"),
            "robot_frontlaser_offset is 'x', which is no number");
  EXPECT_TRUE(contains(why_bad("ROBOTLASER1 0 -1.57 3.14"), "ends before its readings"));
}

}  // namespace
}  // namespace matchbox_slam
