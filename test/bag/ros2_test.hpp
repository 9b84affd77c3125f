#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "bag/ros2_recordings.hpp"
#include "bag/whole_bag.hpp"
#include "io/temporary_folder.hpp"

namespace matchbox_slam {

/// A bag of ROS 1, and its messages as those of ROS 2, to be written as a file of some name.
class Ros2Test : public testing::Test {
 protected:
  explicit Ros2Test(const std::string& name, int scans = 20) : path_(folder_ / name) {
    SmallBag recipe;
    recipe.scans = scans;
    write_whole_bag(bag_, recipe);
    messages_ = as_ros2(bag_);
  }

  TemporaryFolder folder_;
  std::string bag_ = folder_ / "whole.bag";
  std::string path_;
  std::vector<Ros2Message> messages_;
};

}  // namespace matchbox_slam
