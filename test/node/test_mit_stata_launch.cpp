// Of mit_stata.launch: it has been started on a bag of Stata's shape; this looks at what comes out.

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <algorithm>
#include <cstdlib>

#include "bag/bag_reader.hpp"
#include "node/slam_listener.hpp"

namespace matchbox_slam {
namespace {

std::size_t scans_in(const std::string& bag) {
  const BagReader reader({bag});
  for (const BagTopic& topic : reader.topics()) {
    if (topic.name == "/base_scan") {
      return topic.messages;
    }
  }
  return 0;
}

TEST(MitStataLaunch, MapsTheBag) {
  SlamListener listener;
  const std::size_t scans = scans_in(ros::param::param<std::string>("~bag", ""));
  ASSERT_GT(scans, 0U);
  // Although their clock is 82.2 s behind. That is found to some milliseconds, so that the first
  // scan or the last may fall beside the transforms.
  const auto used = [&] { return std::atoi(listener.value_of("Scans used").c_str()); };
  const int nearly_all = static_cast<int>(scans) - 2;
  EXPECT_TRUE(listener.wait_until([&] { return used() >= nearly_all; }, 90.0))
      << used() << " of " << scans << " scans were used";
  EXPECT_TRUE(
      listener.wait_until([&] { return !listener.poses.empty() && !listener.leads.empty(); }, 5.0));
  const nav_msgs::OccupancyGrid map = listener.latched_map();
  EXPECT_EQ(map.header.frame_id, "map");
  EXPECT_GT(std::count_if(map.data.begin(), map.data.end(), [](int value) { return value > 65; }),
            200);
  EXPECT_TRUE(listener.transforms.covers("map", "base_footprint", ros::Time(0)));
  EXPECT_TRUE(listener.transforms.covers("map", "base_laser_link", ros::Time(0)));
}

}  // namespace
}  // namespace matchbox_slam
