// The panel of rviz, as a plugin. Its description is in rviz_plugins.xml.

#include <pluginlib/class_list_macros.hpp>

#include "rviz/slam_panel.hpp"

PLUGINLIB_EXPORT_CLASS(matchbox_slam::SlamPanel, rviz::Panel)
