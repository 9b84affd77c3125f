#include <gtest/gtest.h>

#include "common/error_text.hpp"
#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "node/ros_parameters.hpp"

namespace matchbox_slam {
namespace {

TEST(RosParameters, AreTheSameAsFromYaml) {
  const Parameters from_yaml = parse_yaml_parameters(
      "flag: true\ncount: 3\nreal: 0.5\nword: monte_carlo\nnumbers: [1, 2.5]\n"
      "words: [a, b]\nmixed: [a, 1]\nempty: []\nsection:\n  inner:\n    deep: -2\n  text: '7'\n",
      "test");
  XmlRpc::XmlRpcValue tree;
  tree["flag"] = true;
  tree["count"] = 3;
  tree["real"] = 0.5;
  tree["word"] = "monte_carlo";
  tree["numbers"][0] = 1;
  tree["numbers"][1] = 2.5;
  tree["words"][0] = "a";
  tree["words"][1] = "b";
  tree["mixed"][0] = "a";
  tree["mixed"][1] = 1;
  tree["empty"].setSize(0);
  tree["section"]["inner"]["deep"] = -2;
  tree["section"]["text"] = "7";
  const Parameters from_server = to_parameters(tree);
  EXPECT_EQ(from_server.values(), from_yaml.values());
}

TEST(RosParameters, NoTreeIsNoParameters) {
  EXPECT_TRUE(to_parameters(XmlRpc::XmlRpcValue()).empty());
}

TEST(RosParameters, RefusesWhatIsNoValue) {
  XmlRpc::XmlRpcValue tree;
  tree["frames"][0]["name"] = "base";
  EXPECT_TRUE(contains(error_text<ConfigurationError>([&] { (void)to_parameters(tree); }),
                       "frames: the value is neither"));
}

}  // namespace
}  // namespace matchbox_slam
