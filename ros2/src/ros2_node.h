// The estimator as a ROS 2 node: sensor topics in, odometry, tf and diagnostics out.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "dds_link.h"
#include "gprodom/config.h"
#include "gprodom/live.h"
#include "messages.h"
#include "settings.h"
#include "wheels.h"

namespace gprodom::ros2 {

struct NodeHooks {
  std::function<void()> alive;                           // for a watchdog; any thread
  std::function<void(const std::string& text)> warning;  // publish thread
  std::function<void(const Status& status)> status;      // publish thread
};

class Ros2Node {
 public:
  // Throws ConfigError, or std::runtime_error where DDS cannot be used.
  Ros2Node(const Config& config, const Settings& settings, NodeHooks hooks);

  // Waits at most 0.1 s and hands what has come to the estimator. One thread only.
  void receive();

 private:
  template <class Message, class ToInput>
  void on(const std::string& topic, ToInput to_input);
  void subscribe();
  void subscribe_wheel();
  Input wheels_of(const WheelSample& middle, double yaw_rate);
  void publish(const Outputs& outputs);
  void publish_antennas(const GprConfig& gpr);
  void publish_counts();
  TimeNs now() const;  // on the clock of use_sim_time
  Quality out() const { return {true, settings_.depth, false}; }

  const Settings settings_;
  const NodeHooks hooks_;
  DdsLink link_;

  // Used by the thread that receives.
  ros_shared::WheelOdometry wheel_;
  ros_shared::Integral distance_, turned_;
  std::int64_t next_counts_ns_ = 0;  // on the steady clock
  Publication counts_;

  std::atomic<TimeNs> simulated_{0};

  // Used by the publish thread.
  Publication odometry_, odometry_map_, revisits_, tf_, tf_static_, diagnostics_, log_;

  std::unique_ptr<Live> live_;  // last: its threads use what is above
};

}  // namespace gprodom::ros2
