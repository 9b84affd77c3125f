#include <gtest/gtest.h>

#include <string>

#include "node/scan_matcher_node.hpp"
#include "ros/messages.hpp"

namespace matchbox_slam {
namespace {

TEST(RivalLink, IsWhatGivesOurFrameAParent) {
  const auto found = [](const std::string& parent, const std::string& child, bool from_others) {
    return find_rival_link(make_link(1.0, parent, child, 0.0), "base_link", "odom", from_others);
  };
  EXPECT_EQ(found("/odom", "/base_link", true), "odom -> base_link") << "wheels";
  EXPECT_EQ(found("wheel_odom", "base_link", true), "wheel_odom -> base_link");
  EXPECT_EQ(found("wheel_odom", "base_link", false), "wheel_odom -> base_link")
      << "of another nodelet in our process";
  EXPECT_EQ(found("odom", "base_link", false), "") << "our own";
  EXPECT_EQ(found("map", "odom", true), "") << "a localiser above us is welcome";
  EXPECT_EQ(found("base_link", "laser", true), "");
}

}  // namespace
}  // namespace matchbox_slam
