# What a program that embeds the core links: matchbox_slam::slam and the modules below it, matchbox_slam::io.
# Part of the catkin package's CMake configuration, and all of it where the core is built without ROS.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 NO_MODULE)
find_dependency(fmt)
find_dependency(PNG)
find_dependency(Threads)
find_dependency(yaml-cpp)
find_dependency(ZLIB)
# In a workspace that builds the package with others at once, its targets have these names already.
if(NOT TARGET matchbox_slam::slam)
  include("${matchbox_slam_DIR}/matchbox_slamTargets.cmake")
endif()
# Only a static library leaves Ceres to be linked.
get_target_property(matchbox_slam_graph_type matchbox_slam::graph TYPE)
if(matchbox_slam_graph_type STREQUAL "STATIC_LIBRARY")
  find_dependency(Ceres)
endif()
