// rosrun matchbox_slam slam_node: the SLAM node without a nodelet manager.

#include "node/node_program.hpp"
#include "node/slam_node.hpp"

int main(int argc, char** argv) {
  return matchbox_slam::run_node(
      argc, argv, "slam", [](const auto& node, const auto& private_node) {
        return std::make_shared<matchbox_slam::SlamNode>(node, private_node);
      });
}
