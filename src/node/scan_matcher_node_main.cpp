// rosrun matchbox_slam scan_matcher_node: laser odometry without a nodelet manager.

#include "node/node_program.hpp"
#include "node/scan_matcher_node.hpp"

int main(int argc, char** argv) {
  using namespace matchbox_slam;
  return run_node(argc, argv, "scan_matcher", describe_options(ScanMatcherNodeOptions()),
                  [](const auto& node, const auto& private_node) {
                    return std::make_shared<ScanMatcherNode>(node, private_node);
                  });
}
