#include <gtest/gtest.h>

#include "common/error_text.hpp"
#include "io/stata_truth.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

std::string truth_refusal(const std::string& text) {
  return error_text<FileError>([&] { (void)parse_stata_truth(text, "my.poses"); });
}

TEST(ParseStataTruth, ReadsMicrosecondsMetresAndRadiansInAnyOrder) {
  const Trajectory trajectory = parse_stata_truth(
      "1327523528014922,29.547,130.611,0.373698\r\n"
      "# a comment\n"
      "\n"
      " 1327523527964909 , 2.5e1 ,-130.608, 3.5",
      "my.poses");
  ASSERT_EQ(trajectory.size(), 2U);
  EXPECT_NEAR(trajectory.poses()[0].stamp, 1327523527.964909, 1e-6);
  EXPECT_EQ(trajectory.poses()[0].pose.x, 25.0);
  EXPECT_EQ(trajectory.poses()[0].pose.y, -130.608);
  EXPECT_NEAR(trajectory.poses()[0].pose.theta, 3.5 - 2.0 * kPi, 1e-12);
  EXPECT_NEAR(trajectory.poses()[1].stamp, 1327523528.014922, 1e-6);
  EXPECT_EQ(trajectory.poses()[1].pose.theta, 0.373698);
}

TEST(ParseStataTruth, NoPosesMakeAnEmptyTrajectory) {
  EXPECT_TRUE(parse_stata_truth("", "my.poses").empty());
  EXPECT_TRUE(parse_stata_truth("# nothing, at all\n\n", "my.poses").empty());
  EXPECT_EQ(parse_stata_truth("1,2,3,0\n", "my.poses").size(), 1U);
}

TEST(ParseStataTruth, RefusalNamesFileAndLine) {
  const std::string good = "1000000,1,2,3\n";
  EXPECT_EQ(truth_refusal(good + "\n2000000,1,2\n"),
            "my.poses:3: has 3 columns between commas; ground truth of MIT Stata has 4: "
            "stamp,x,y,theta (a TUM trajectory has 8, between blanks)");
  EXPECT_TRUE(contains(truth_refusal(good + "2000000,1,2,3,\n"), "my.poses:2: has 5 columns"));
  EXPECT_TRUE(contains(truth_refusal("1 0 0 0 0 0 0 1\n"), "my.poses:1: has 1 columns"));
  EXPECT_EQ(truth_refusal(good + "2000000,one,2,3\n"),
            "my.poses:2: x is 'one', not a finite number");
  EXPECT_EQ(truth_refusal(good + "2000000,1,nan,3\n"),
            "my.poses:2: y is 'nan', not a finite number");
  EXPECT_EQ(truth_refusal(good + "2000000,1,2,\n"), "my.poses:2: theta is '', not a finite number");
  EXPECT_EQ(truth_refusal("1327523528.01,1,2,3\n"),
            "my.poses:1: stamp is '1327523528.01'; ground truth of MIT Stata has whole "
            "microseconds");
  EXPECT_EQ(truth_refusal(good + good),
            "my.poses: two poses have the stamp 1.000000; remove one of them");
}

TEST(LooksLikeStataTruth, TellsItFromTumByACommaOutsideComments) {
  EXPECT_TRUE(looks_like_stata_truth("# laser poses\n\n1,2,3,4\n"));
  EXPECT_FALSE(looks_like_stata_truth("# stamp, x, y\n1 0 0 0 0 0 0 1 # here, too\n"));
  EXPECT_FALSE(looks_like_stata_truth(""));
}

}  // namespace
}  // namespace matchbox_slam
