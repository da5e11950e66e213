// The daemon's connection to LCM: a thread that receives, and publishing from any thread.
#pragma once

#include <atomic>
#include <functional>
#include <lcm/lcm-cpp.hpp>
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
  LcmLink(const std::string& url, const ChannelConfig& channels, Sink sink);
  ~LcmLink();  // stop_receiving()
  LcmLink(const LcmLink&) = delete;
  LcmLink& operator=(const LcmLink&) = delete;

  // No Sink call is under way or to come when this returns.
  void stop_receiving();

  // Any thread.
  void publish(const std::vector<LcmMessage>& messages);

 private:
  void receive();
  void take(const lcm::ReceiveBuffer* packet, const std::string& channel);

  const ChannelConfig channels_;
  const Sink sink_;
  lcm::LCM lcm_;  // guards itself
  std::atomic<bool> stopping_{false};
  std::thread receiver_;  // last, so that everything above is there when it starts
};

}  // namespace gprodom
