// rosrun matchbox_slam slam_node: the SLAM node without a nodelet manager.

#include "node/node_program.hpp"
#include "node/slam_node.hpp"

int main(int argc, char** argv) {
  using namespace matchbox_slam;
  return run_node(argc, argv, "slam", describe_node_options(),
                  [](const auto& node, const auto& private_node) {
                    return std::make_shared<SlamNode>(node, private_node);
                  });
}
