#include "io/lcm_link.h"

#include <cctype>
#include <chrono>
#include <stdexcept>
#include <utility>

namespace gprodom {
namespace {

constexpr int kQueueCapacity = 10000;  // messages per channel, for bursts; LCM's default is 30
constexpr int kPollMs = 100;           // how long a stop may take

// A socket buffer for bursts too, unless the operator has set one.
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

[[noreturn]] void fail(const std::string& url) {
  throw std::runtime_error("LCM URL " + url + ": cannot be used; expected one like " +
                           kDefaultLcmUrl +
                           " and a route for multicast (ip route add 224.0.0.0/4 dev lo)");
}

}  // namespace

LcmLink::LcmLink(const std::string& url, const ChannelConfig& channels, Sink sink)
    : channels_(channels), sink_(std::move(sink)), lcm_(with_receive_buffer(url)) {
  if (!lcm_.good()) fail(url);
  for (const auto& name : input_channels(channels_)) {
    // Raw packets, since the generated decoders must not see them unchecked.
    lcm::Subscription* subscription = lcm_.subscribeFunction<LcmLink*>(
        escaped(name),
        [](const lcm::ReceiveBuffer* packet, const std::string& channel, LcmLink* link) {
          link->take(packet, channel);
        },
        this);
    if (!subscription) fail(url);
    subscription->setQueueCapacity(kQueueCapacity);
  }
  receiver_ = std::thread([this] { receive(); });
}

LcmLink::~LcmLink() { stop_receiving(); }

void LcmLink::stop_receiving() {
  stopping_ = true;
  if (receiver_.joinable()) receiver_.join();
}

void LcmLink::receive() {
  while (!stopping_) {
    if (lcm_.handleTimeout(kPollMs) < 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(kPollMs));  // LCM says why itself
    }
  }
}

void LcmLink::take(const lcm::ReceiveBuffer* packet, const std::string& channel) {
  auto input = decode_input(channels_, channel, packet->data, packet->data_size);
  if (input) sink_(std::move(*input));
}

void LcmLink::publish(const std::vector<LcmMessage>& messages) {
  for (const auto& message : messages) {
    lcm_.publish(message.channel, message.data.data(),
                 static_cast<unsigned int>(message.data.size()));
  }
}

}  // namespace gprodom
