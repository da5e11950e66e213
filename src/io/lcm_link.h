// The daemon's connection to LCM. It has no thread of its own: it works in the thread that calls
// receive().
#pragma once

#include <lcm/lcm.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gprodom/lcm_io.h"

namespace gprodom {

constexpr char kDefaultLcmUrl[] = "udpm://239.255.76.67:7667?ttl=0";  // nothing leaves the machine

class LcmLink {
 public:
  // Called by receive() for each message on one of our channels; must not wait.
  using Sink = std::function<void(Input)>;
  // Called by receive() with the instance number of each STATUS on our channel, our own ones too.
  using OnStatus = std::function<void(double)>;

  // Throws std::runtime_error, with what to do, where LCM cannot be used.
  explicit LcmLink(const std::string& url);
  ~LcmLink();
  LcmLink(const LcmLink&) = delete;
  LcmLink& operator=(const LcmLink&) = delete;

  // Not while another thread is in receive(). Throws std::runtime_error.
  void subscribe(const ChannelConfig& channels, Sink sink, OnStatus on_status);
  void unsubscribe();

  // Waits at most 0.1 s for a message and hands what has arrived to the sink. For one thread only.
  // False if LCM failed (it has printed why): try again a moment later.
  bool receive();

  // Any thread.
  void publish(const std::vector<LcmMessage>& messages);

 private:
  using Handler = void (*)(const lcm_recv_buf_t*, const char*, void*);
  void subscribe(const std::string& channel, Handler handler);
  static void take(const lcm_recv_buf_t* packet, const char* channel, void* link);
  static void take_status(const lcm_recv_buf_t* packet, const char* channel, void* link);

  const std::string url_;
  const std::unique_ptr<lcm_t, void (*)(lcm_t*)> lcm_;  // guards itself

  // Written only while no thread is in receive().
  ChannelConfig channels_;
  Sink sink_;
  OnStatus on_status_;
  std::vector<lcm_subscription_t*> subscriptions_;
};

}  // namespace gprodom
