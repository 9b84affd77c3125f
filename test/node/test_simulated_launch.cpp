// Of simulated.launch: it has been started; this looks at what comes out, and clears up.

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <filesystem>

#include "node/slam_listener.hpp"

namespace matchbox_slam {
namespace {

TEST(SimulatedLaunch, SimulatesAndMaps) {
  SlamListener listener;
  // 10 s at 20 Hz
  EXPECT_TRUE(listener.wait_until([&] { return listener.value_of("Scans used") == "201"; }, 90.0))
      << listener.value_of("Scans used") << " of 201 scans were used";
  const auto bag = ros::param::param<std::string>("~bag", "");
  EXPECT_TRUE(std::filesystem::remove(bag)) << bag;
  EXPECT_TRUE(std::filesystem::remove(bag + ".truth.tum")) << bag;
}

}  // namespace
}  // namespace matchbox_slam
