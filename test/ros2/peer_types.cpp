#include "peer_types.h"

#include <functional>
#include <map>

#include "messagesPubSubTypes.h"
#include "messagesTypeObject.h"

using eprosima::fastdds::dds::TypeSupport;

namespace {

using Makers = std::map<std::string, std::function<TypeSupport()>>;

template <class... Types>
Makers makers() {
  Makers all;
  (all.emplace(Types().getName(), [] { return TypeSupport(new Types()); }), ...);
  return all;
}

bool type_objects = false;

}  // namespace

TypeSupport make_type(const std::string& name) {
  static const Makers all =
      makers<std_msgs::msg::Int64PubSubType, rosgraph_msgs::msg::ClockPubSubType,
             rcl_interfaces::msg::LogPubSubType,
             geometry_msgs::msg::PoseWithCovarianceStampedPubSubType,
             geometry_msgs::msg::TwistStampedPubSubType, tf2_msgs::msg::TFMessagePubSubType,
             nav_msgs::msg::OdometryPubSubType, sensor_msgs::msg::ImuPubSubType,
             sensor_msgs::msg::NavSatFixPubSubType, sensor_msgs::msg::JointStatePubSubType,
             diagnostic_msgs::msg::DiagnosticArrayPubSubType, gprodom_msgs::msg::GprTracePubSubType,
             gprodom_msgs::msg::RevisitPubSubType, gprodom_msgs::msg::CommandPubSubType>();
  TypeSupport type = all.at(name)();
  type->auto_fill_type_object(type_objects);
  type->auto_fill_type_information(type_objects);
  return type;
}

void announce_type_objects() {
  type_objects = true;
  registermessagesTypes();
}
