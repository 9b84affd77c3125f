#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <sstream>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

std::string tum_refusal(const std::string& text) {
  return error_text<FileError>([&] { (void)parse_tum(text, "my.tum"); });
}

TEST(ParseTum, ReadsPosesInAnyOrderBetweenCommentsAndBlankLines) {
  const Trajectory trajectory = parse_tum(
      "# stamp x y z qx qy qz qw\n"
      "\n"
      "2.5  1 -2 0.3  0 0 1 0   # turned by half\r\n"
      "\t 1.25 3e-1 4 0 0 0 0.7071067811865476 0.7071067811865476\n"
      "   \n"
      "3 0 0 0 0 0 -0.247403959 0.968912422",
      "my.tum");
  ASSERT_EQ(trajectory.size(), 3U);
  EXPECT_EQ(trajectory.poses()[0].stamp, 1.25);
  EXPECT_EQ(trajectory.poses()[0].pose.x, 0.3);
  EXPECT_NEAR(trajectory.poses()[0].pose.theta, 0.5 * kPi, 1e-12);
  EXPECT_EQ(trajectory.poses()[1].pose.y, -2.0);
  EXPECT_NEAR(std::abs(trajectory.poses()[1].pose.theta), kPi, 1e-12);
  EXPECT_NEAR(trajectory.poses()[2].pose.theta, -0.5, 1e-8);
}

TEST(ParseTum, TakesTheYawOfARotationInSpace) {
  const Eigen::Quaterniond q = Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX());
  std::ostringstream line;
  line.precision(17);
  line << "1 0 0 0 " << q.x() << ' ' << q.y() << ' ' << q.z() << ' ' << q.w();
  EXPECT_NEAR(parse_tum(line.str(), "my.tum").poses()[0].pose.theta, 1.0, 1e-12);
}

TEST(ParseTum, NoPosesMakeAnEmptyTrajectory) {
  EXPECT_TRUE(parse_tum("", "my.tum").empty());
  EXPECT_TRUE(parse_tum("# nothing\n\n", "my.tum").empty());
  EXPECT_EQ(parse_tum("1 0 0 0 0 0 0 1", "my.tum").size(), 1U);
}

TEST(ParseTum, RefusalNamesFileAndLine) {
  const std::string good = "1 0 0 0 0 0 0 1\n";
  EXPECT_EQ(tum_refusal(good + "\n2 0 0 0 0 0 1\n"),
            "my.tum:3: has 7 columns; a TUM trajectory has 8: stamp x y z qx qy qz qw");
  EXPECT_EQ(tum_refusal(good + "2 0 0 0 0 0 0 1 9\n"),
            "my.tum:2: has 9 columns; a TUM trajectory has 8: stamp x y z qx qy qz qw");
  EXPECT_EQ(tum_refusal(good + "2 zero 0 0 0 0 0 1\n"),
            "my.tum:2: x is 'zero', not a finite number");
  EXPECT_EQ(tum_refusal(good + "2 0 nan 0 0 0 0 1\n"), "my.tum:2: y is 'nan', not a finite number");
  EXPECT_EQ(tum_refusal(good + "2 0 0 0 0 0 inf 1\n"),
            "my.tum:2: qz is 'inf', not a finite number");
  EXPECT_EQ(tum_refusal(good + "1,5 0 0 0 0 0 0 1\n"),
            "my.tum:2: stamp is '1,5', not a finite number");
  EXPECT_EQ(tum_refusal("1 0 0 0 0 0 0 0\n"),
            "my.tum:1: the quaternion (qx qy qz qw) has the length 0, not 1");
  EXPECT_EQ(tum_refusal(good + good),
            "my.tum: two poses have the stamp 1.000000; remove one of them");
}

TEST(ToTum, WritesSixDecimalsOfStampsAndNineOfTheRest) {
  const Trajectory trajectory(
      {{1411657682.0428591, {0.5, -2.0 / 3.0, 0.5 * kPi}}, {1411657683.0, {1, 2, -kPi}}});
  EXPECT_EQ(to_tum(trajectory),
            "1411657682.042859 0.500000000 -0.666666667 0.000000000 0.000000000 0.000000000 "
            "0.707106781 0.707106781\n"
            "1411657683.000000 1.000000000 2.000000000 0.000000000 0.000000000 0.000000000 "
            "-1.000000000 0.000000000\n");
  EXPECT_EQ(to_tum({}), "");
}

TEST(WriteTum, ReadsBackToTheLastDecimal) {
  const TemporaryFolder folder;
  const Trajectory trajectory({{10.125, {1.5, -2.25, 3.0}}, {11.5, {-1e3, 1e3, -3.0}}});
  write_tum(folder / "t.tum", trajectory);
  const Trajectory read = read_tum(folder / "t.tum");
  ASSERT_EQ(read.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.poses()[i].stamp, trajectory.poses()[i].stamp);
    EXPECT_EQ(read.poses()[i].pose.x, trajectory.poses()[i].pose.x);
    EXPECT_EQ(read.poses()[i].pose.y, trajectory.poses()[i].pose.y);
    EXPECT_NEAR(read.poses()[i].pose.theta, trajectory.poses()[i].pose.theta, 2e-8);
  }
  EXPECT_THROW((void)read_tum(folder / "none.tum"), FileError);
}

TEST(Tum, PartsOfADriveHaveNamesOfTheirOwn) {
  EXPECT_EQ(path_of_part("/out/drive.tum", 2, 3), "/out/drive.tum");
  EXPECT_EQ(path_of_part("/out/drive.tum", 0, 3), "/out/drive.1.tum");
  EXPECT_EQ(path_of_part("/out/drive.tum", 1, 3), "/out/drive.2.tum");
  EXPECT_EQ(path_of_part("drive", 0, 2), "drive.1");
}

}  // namespace
}  // namespace matchbox_slam
