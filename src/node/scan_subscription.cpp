#include "node/scan_subscription.hpp"

#include <fmt/core.h>
#include <ros/console.h>
#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <ros/subscribe_options.h>

#include <boost/make_shared.hpp>
#include <typeinfo>
#include <utility>

#include "matchbox_slam/common/options.hpp"
#include "node/scan_worker.hpp"

namespace matchbox_slam {
namespace {

using sensor_msgs::LaserScan;
using sensor_msgs::MultiEchoLaserScan;
using sensor_msgs::PointCloud2;

using HeaderPtr = boost::shared_ptr<ros::M_string>;

const std::string& value_of(const HeaderPtr& header, const std::string& key) {
  static const std::string kNone;
  if (header == nullptr) {
    return kNone;
  }
  const auto found = header->find(key);
  return found == header->end() ? kNone : found->second;
}

/// Whether a publisher says that it sends messages of this type, in the definition that we know.
template <typename Message>
bool sends(const HeaderPtr& header) {
  // Compared in place, and keys so short that nothing is allocated for a scan.
  return value_of(header, "type") == ros::message_traits::datatype<Message>() &&
         value_of(header, "md5sum") == ros::message_traits::md5sum<Message>();
}

template <typename Message>
ros::VoidConstPtr deserialized(const ros::SubscriptionCallbackHelperDeserializeParams& params) {
  const auto message = boost::make_shared<Message>();
  ros::serialization::IStream stream(params.buffer, params.length);
  ros::serialization::deserialize(stream, *message);
  return message;
}

/// Takes messages apart by what their publisher says they are. To roscpp this subscribes to laser
/// scans, of whatever md5sum: so these are handed over within a process as they are, and all else
/// as bytes.
class ScanHelper : public ros::SubscriptionCallbackHelper {
 public:
  ScanHelper(const CloudOptions& cloud, std::function<void(const ScanArrival&)> callback)
      : cloud_(cloud), callback_(std::move(callback)) {}

  ros::VoidConstPtr deserialize(
      const ros::SubscriptionCallbackHelperDeserializeParams& params) override {
    const HeaderPtr& header = params.connection_header;
    if (sends<LaserScan>(header)) {
      return deserialized<LaserScan>(params);
    }
    if (sends<MultiEchoLaserScan>(header)) {
      return deserialized<MultiEchoLaserScan>(params);
    }
    if (sends<PointCloud2>(header)) {
      return deserialized<PointCloud2>(params);
    }
    const std::string type = value_of(header, "type");
    ROS_WARN_STREAM_THROTTLE(
        10.0,
        value_of(header, "callerid")
            << " publishes " << type << " on " << value_of(header, "topic")
            << (is_scan_type(type) ? fmt::format(" in a definition that is not ours (md5sum {})",
                                                 value_of(header, "md5sum"))
                                   : std::string(", which is no scan"))
            << "; it is ignored. Allowed: " << join(scan_types()));
    return {};
  }

  void call(ros::SubscriptionCallbackHelperCallParams& params) override {
    callback_({message_of(params.event), params.event.getReceiptTime()});
  }

  const std::type_info& getTypeInfo() override { return typeid(LaserScan); }
  bool isConst() override { return true; }
  bool hasHeader() override { return true; }

 private:
  [[nodiscard]] ScanMessage message_of(const ros::MessageEvent<void const>& event) const {
    const HeaderPtr& header = event.getConnectionHeaderPtr();
    const ros::VoidConstPtr& message = event.getConstMessage();
    if (sends<MultiEchoLaserScan>(header)) {
      return to_scan(*boost::static_pointer_cast<const MultiEchoLaserScan>(message));
    }
    if (sends<PointCloud2>(header)) {
      return to_scan(*boost::static_pointer_cast<const PointCloud2>(message), cloud_);
    }
    return to_scan(boost::static_pointer_cast<const LaserScan>(message));
  }

  const CloudOptions cloud_;
  const std::function<void(const ScanArrival&)> callback_;
};

}  // namespace

ros::Subscriber subscribe_to_scans(ros::NodeHandle& node, const std::string& topic,
                                   const CloudOptions& cloud,
                                   std::function<void(const ScanArrival&)> callback) {
  ros::SubscribeOptions options(topic, kScanMessages, "*", "*");
  options.helper = boost::make_shared<ScanHelper>(cloud, std::move(callback));
  options.transport_hints = ros::TransportHints().tcpNoDelay();
  return node.subscribe(options);
}

}  // namespace matchbox_slam
