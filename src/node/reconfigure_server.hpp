#pragma once

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/service_server.h>

#include <functional>
#include <vector>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {

/// The server side of dynamic_reconfigure over a list of options, as rqt_reconfigure and dynparam
/// talk to it. What dynamic_reconfigure generates from a .cfg file would say every option a second
/// time, and could not know those of matchers from other packages.
class ReconfigureServer {
 public:
  /// Takes the values that are to change. Throws to refuse them, all of them; returns the options
  /// as they are then.
  using Change = std::function<std::vector<OptionDescription>(const Parameters&)>;

  /// @param private_node  where the topics and the service go; its queue calls `change`.
  /// @param options  with their present values. Lists are left out.
  ReconfigureServer(const ros::NodeHandle& private_node,
                    const std::vector<OptionDescription>& options, Change change);

 private:
  bool answer(dynamic_reconfigure::Reconfigure::Request& request,
              dynamic_reconfigure::Reconfigure::Response& response);
  void keep_on_parameter_server(const dynamic_reconfigure::Config& config);

  ros::NodeHandle private_node_;
  Change change_;
  dynamic_reconfigure::Config values_;
  ros::Publisher descriptions_;
  ros::Publisher updates_;
  ros::ServiceServer service_;
};

}  // namespace matchbox_slam
