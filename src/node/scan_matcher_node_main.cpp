// rosrun matchbox_slam scan_matcher_node: laser odometry without a nodelet manager.

#include "node/node_program.hpp"
#include "node/scan_matcher_node.hpp"

int main(int argc, char** argv) {
  return matchbox_slam::run_node(
      argc, argv, "scan_matcher", [](const auto& node, const auto& private_node) {
        return std::make_shared<matchbox_slam::ScanMatcherNode>(node, private_node);
      });
}
