// The daemon's connection to LCM: a thread that receives, and publishing from any thread.
#pragma once

#include <lcm/lcm.h>

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "gprodom/lcm_io.h"

namespace gprodom {

constexpr char kDefaultLcmUrl[] = "udpm://239.255.76.67:7667?ttl=0";  // nothing leaves the machine

class LcmLink {
 public:
  // Called on the receive thread for each message on one of our channels; must not wait.
  using Sink = std::function<void(Input)>;

  // Throws std::runtime_error, with what to do, where LCM cannot be used.
  explicit LcmLink(const std::string& url);
  ~LcmLink();  // stop_receiving()
  LcmLink(const LcmLink&) = delete;
  LcmLink& operator=(const LcmLink&) = delete;

  // Not while receiving already. Throws std::runtime_error.
  void start_receiving(const ChannelConfig& channels, Sink sink);

  // No Sink call is under way or to come when this returns.
  void stop_receiving();

  // Any thread.
  void publish(const std::vector<LcmMessage>& messages);

 private:
  void receive();
  static void take(const lcm_recv_buf_t* packet, const char* channel, void* link);

  const std::string url_;
  const std::unique_ptr<lcm_t, void (*)(lcm_t*)> lcm_;  // guards itself

  // Written only while receiver_ does not run.
  ChannelConfig channels_;
  Sink sink_;
  std::vector<lcm_subscription_t*> subscriptions_;

  std::atomic<bool> stopping_{false};
  std::thread receiver_;
};

}  // namespace gprodom
