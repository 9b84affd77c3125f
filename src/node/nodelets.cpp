// The nodes in a nodelet manager, where scans of other nodelets arrive without being copied.

#include <nodelet/nodelet.h>

#include <exception>
#include <memory>
#include <pluginlib/class_list_macros.hpp>

#include "node/scan_matcher_node.hpp"
#include "node/slam_node.hpp"

namespace matchbox_slam {

template <typename Node>
class NodeNodelet : public nodelet::Nodelet {
 private:
  /// Throws when the node does: the manager then refuses to load the nodelet, but may not say why.
  void onInit() override {
    try {
      node_ = std::make_unique<Node>(getNodeHandle(), getPrivateNodeHandle());
    } catch (const std::exception& error) {
      NODELET_FATAL_STREAM(error.what());
      throw;
    }
  }

  std::unique_ptr<Node> node_;
};

using SlamNodelet = NodeNodelet<SlamNode>;
using ScanMatcherNodelet = NodeNodelet<ScanMatcherNode>;

}  // namespace matchbox_slam

PLUGINLIB_EXPORT_CLASS(matchbox_slam::SlamNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(matchbox_slam::ScanMatcherNodelet, nodelet::Nodelet)
