# What a program that embeds the core links: matchbox_slam::slam and the rooms below it, matchbox_slam::io.
# Part of the catkin package's CMake configuration, and all of it where the core is built without ROS.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 NO_MODULE)
find_dependency(Threads)
find_dependency(yaml-cpp)
find_dependency(ZLIB)
# In a workspace that builds the package with others at once, its targets have these names already.
if(NOT TARGET matchbox_slam::slam)
  include("${matchbox_slam_DIR}/matchbox_slamTargets.cmake")
endif()
