#include <nodelet/nodelet.h>

#include <memory>
#include <pluginlib/class_list_macros.hpp>

#include "matchbox_slam/ros/slam_node.hpp"

namespace matchbox_slam {

/// SlamNode in a nodelet manager, where scans of other nodelets arrive without being copied.
class SlamNodelet : public nodelet::Nodelet {
 private:
  /// Throws when SlamNode does: the manager then says why and refuses to load the nodelet.
  void onInit() override {
    node_ = std::make_unique<SlamNode>(getNodeHandle(), getPrivateNodeHandle());
  }

  std::unique_ptr<SlamNode> node_;
};

}  // namespace matchbox_slam

PLUGINLIB_EXPORT_CLASS(matchbox_slam::SlamNodelet, nodelet::Nodelet)
