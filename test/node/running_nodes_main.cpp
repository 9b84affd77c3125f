// Tests that talk to running nodes: test_running_nodes SUITE... runs these suites.

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <cstdio>
#include <string>

namespace {

bool is_suite(const std::string& name) {
  const testing::UnitTest& all = *testing::UnitTest::GetInstance();
  for (int i = 0; i < all.total_test_suite_count(); ++i) {
    if (all.GetTestSuite(i)->name() == name) {
      return true;
    }
  }
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "test_running_nodes");
  std::string filter;
  for (int i = 1; i < argc; ++i) {
    const std::string suite = argv[i];
    if (suite.rfind('-', 0) == 0) {
      continue;  // such as rostest's --text
    }
    // With no tests to run a .test file would pass.
    if (!is_suite(suite)) {
      std::fprintf(stderr, "there is no suite %s of tests\n", suite.c_str());
      return 2;
    }
    filter += suite + ".*:";
  }
  if (filter.empty()) {
    std::fprintf(stderr, "name the suites whose nodes run\n");
    return 2;
  }
  testing::GTEST_FLAG(filter) = filter;
  const ros::NodeHandle keeps_ros_alive;
  return RUN_ALL_TESTS();
}
