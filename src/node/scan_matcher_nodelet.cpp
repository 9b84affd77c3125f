#include <nodelet/nodelet.h>

#include <exception>
#include <memory>
#include <pluginlib/class_list_macros.hpp>

#include "node/scan_matcher_node.hpp"

namespace matchbox_slam {

/// ScanMatcherNode in a nodelet manager, where scans of other nodelets arrive without being copied.
class ScanMatcherNodelet : public nodelet::Nodelet {
 private:
  /// Throws when ScanMatcherNode does: the manager then refuses to load the nodelet, but may not
  /// say why.
  void onInit() override {
    try {
      node_ = std::make_unique<ScanMatcherNode>(getNodeHandle(), getPrivateNodeHandle());
    } catch (const std::exception& error) {
      NODELET_FATAL_STREAM(error.what());
      throw;
    }
  }

  std::unique_ptr<ScanMatcherNode> node_;
};

}  // namespace matchbox_slam

PLUGINLIB_EXPORT_CLASS(matchbox_slam::ScanMatcherNodelet, nodelet::Nodelet)
