#include "io/lcm_link.h"

#include <cctype>
#include <stdexcept>
#include <utility>

#include "io/status_instance.h"

namespace gprodom {
namespace {

constexpr int kQueueCapacity = 10000;  // messages per channel, for bursts; LCM's default is 30
constexpr int kPollMs = 100;           // the longest wait in receive()

// Adds a socket buffer that is large enough for bursts, unless the operator has set one.
std::string with_receive_buffer(const std::string& url) {
  if (url.rfind("udpm://", 0) != 0 || url.find("recv_buf_size") != std::string::npos) return url;
  return url + (url.find('?') == std::string::npos ? "?" : "&") + "recv_buf_size=4194304";
}

// LCM takes channel names as regular expressions.
std::string escaped(const std::string& name) {
  std::string pattern;
  for (const char c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_') pattern += '\\';
    pattern += c;
  }
  return pattern;
}

[[noreturn]] void fail_at(const std::string& url) {
  throw std::runtime_error("LCM URL " + url + ": cannot be used; expected one like " +
                           kDefaultLcmUrl +
                           " and a route for multicast (ip route add 224.0.0.0/4 dev lo)");
}

}  // namespace

LcmLink::LcmLink(const std::string& url)
    : url_(url), lcm_(lcm_create(with_receive_buffer(url).c_str()), lcm_destroy) {
  if (!lcm_) fail_at(url);
}

LcmLink::~LcmLink() { unsubscribe(); }

void LcmLink::subscribe(const ChannelConfig& channels, Sink sink, OnStatus on_status) {
  channels_ = channels;
  sink_ = std::move(sink);
  on_status_ = std::move(on_status);
  for (const auto& name : input_channels(channels_)) subscribe(name, &LcmLink::take);
  subscribe(channels_.status, &LcmLink::take_status);
}

// Subscribes to raw packets: they must be checked before a generated decoder reads them.
void LcmLink::subscribe(const std::string& channel, Handler handler) {
  lcm_subscription_t* subscription =
      lcm_subscribe(lcm_.get(), escaped(channel).c_str(), handler, this);
  if (!subscription) fail_at(url_);
  lcm_subscription_set_queue_capacity(subscription, kQueueCapacity);
  subscriptions_.push_back(subscription);
}

void LcmLink::unsubscribe() {
  for (lcm_subscription_t* subscription : subscriptions_) {
    lcm_unsubscribe(lcm_.get(), subscription);
  }
  subscriptions_.clear();
}

bool LcmLink::receive() { return lcm_handle_timeout(lcm_.get(), kPollMs) >= 0; }

void LcmLink::take(const lcm_recv_buf_t* packet, const char* channel, void* self) {
  const auto* link = static_cast<const LcmLink*>(self);
  auto input = decode_input(link->channels_, channel, packet->data, packet->data_size);
  if (input) link->sink_(std::move(*input));
}

void LcmLink::take_status(const lcm_recv_buf_t* packet, const char* /*channel*/, void* self) {
  const auto instance = instance_of(packet->data, packet->data_size);
  if (instance) static_cast<const LcmLink*>(self)->on_status_(*instance);
}

void LcmLink::publish(const std::vector<LcmMessage>& messages) {
  for (const auto& message : messages) {
    lcm_publish(lcm_.get(), message.channel.c_str(), message.data.data(),
                static_cast<unsigned int>(message.data.size()));
  }
}

}  // namespace gprodom
