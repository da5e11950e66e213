// The node's connection to DDS by Cyclone DDS: subscriptions and publications of ROS 2 topics.
#pragma once

#include <dds/dds.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cdr.h"
#include "raw_type.h"
#include "settings.h"

namespace gprodom::ros2 {

struct Quality {  // of service
  bool reliable = true;
  int depth = 10;
  bool for_late_subscribers = false;  // transient local
};

// What a subscription has met with since the start.
struct Counts {
  std::uint64_t received = 0;      // messages, the refused ones included
  std::uint64_t refused = 0;       // of them: not bytes of the type
  std::uint64_t lost = 0;          // sent, by their publishers' numbers, and not received
  std::uint64_t publishers = 0;    // now
  std::uint64_t incompatible = 0;  // publishers whose quality of service does not match
  std::uint64_t other_types = 0;   // publishers of another type under the topic's name
};

// Any thread.
class Publication {
 public:
  Publication() = default;
  Publication(dds_entity_t writer, const ddsi_sertype* type) : writer_(writer), type_(type) {}

  // Never waits for a subscriber. A message that cannot be sent at once is not sent.
  template <class Message>
  void operator()(const Message& message) const {
    if (writer_ > 0 && !write_raw(writer_, type_, to_cdr(message))) ++*unsent_;
  }

  std::uint64_t unsent() const { return *unsent_; }

 private:
  dds_entity_t writer_ = 0;
  const ddsi_sertype* type_ = nullptr;
  std::shared_ptr<std::atomic<std::uint64_t>> unsent_ =
      std::make_shared<std::atomic<std::uint64_t>>(0);
};

class DdsLink {
 public:
  // Of a message that could not be used: the topic as in the settings, and the reason.
  using OnRefused = std::function<void(const std::string& topic, const std::string& reason)>;

  // Throws std::runtime_error, with what to do, where DDS cannot be used.
  DdsLink(const Settings& settings, OnRefused on_refused);
  ~DdsLink();
  DdsLink(const DdsLink&) = delete;
  DdsLink& operator=(const DdsLink&) = delete;

  // `take` is called by receive() for each message.
  template <class Message>
  void subscribe(const std::string& topic, const Quality& quality,
                 std::function<void(const Message&)> take) {
    subscribe(topic, Message::kType, quality, [take](const std::uint8_t* cdr, std::size_t size) {
      take(from_cdr<Message>(cdr, size));
    });
  }

  template <class Message>
  Publication publish(const std::string& topic, const Quality& quality) {
    return publish(topic, Message::kType, quality);
  }

  // Waits at most 0.1 s for messages and hands over what has come. One thread only.
  void receive();

  // By topic. Of the thread that calls receive().
  std::vector<std::pair<std::string, Counts>> counts() const;

 private:
  // Throws CdrError.
  using Take = std::function<void(const std::uint8_t* cdr, std::size_t size)>;
  struct Subscription {
    std::string topic, wire_name, type;
    Take take;
    dds_entity_t reader = 0;
    Counts counts;
    std::map<dds_instance_handle_t, std::int64_t> last;  // number of each publisher's messages
  };

  void subscribe(const std::string& topic, const std::string& type, const Quality& quality,
                 Take take);
  Publication publish(const std::string& topic, const std::string& type, const Quality& quality);
  void take(Subscription& subscription);
  static void count(Subscription& subscription, const Origin& origin);
  void watch_publishers();

  const Settings settings_;
  const OnRefused on_refused_;
  dds_entity_t domain_ = 0, participant_ = 0, waitset_ = 0, publishers_ = 0;
  std::list<Subscription> subscriptions_;  // whose places the waitset knows
};

}  // namespace gprodom::ros2
