// A program on Fast DDS, the DDS that ROS 2 has by default, that sends messages and writes down
// what it receives, for the tests of gprodom_ros2:
//
//   peer PLAN OUT [--domain N] [--quiet-s S] [--type-objects] [--subscribe TOPIC TYPE QUALITY]...
//
// PLAN: records, each a kind (uint8), a time (int64 ns from the start), and topic, type and CDR of
// a message, each after its length (uint32). Kind 0: the message is read into the type that
// fastddsgen made and written from there. Kind 1: the bytes are sent as they are, under the type's
// name. OUT: records of the same form; kind 0: a message was sent, 1: received; times on the
// monotonic clock. QUALITY: r reliable, b best effort, t reliable and transient local. Publishers
// are reliable.
//
// It says "matched" when each subscription has a publisher, and each publisher of kind 0 a
// subscriber (30 s at most). It begins to send at a line on standard input, since the other side
// may not know yet what it has matched here; says "sent"; and ends when nothing has come for S
// seconds (2), or on SIGTERM.
#include <poll.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "peer_types.h"

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

namespace {

using Bytes = std::vector<std::uint8_t>;

struct Record {
  std::uint8_t kind = 0;
  std::int64_t at_ns = 0;
  std::string topic, type;
  Bytes cdr;
};

std::atomic<bool> ended{false};

std::int64_t now_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// ---- records ----

template <class Text>
bool read_text(std::istream& in, Text& text) {
  std::uint32_t size = 0;
  if (!in.read(reinterpret_cast<char*>(&size), sizeof size)) return false;
  text.resize(size);
  return static_cast<bool>(in.read(reinterpret_cast<char*>(text.data()), size));
}

template <class Text>
void write_text(std::ostream& out, const Text& text) {
  const auto size = static_cast<std::uint32_t>(text.size());
  out.write(reinterpret_cast<const char*>(&size), sizeof size);
  out.write(reinterpret_cast<const char*>(text.data()), size);
}

std::vector<Record> read_plan(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(path + ": cannot be read");
  std::vector<Record> plan;
  for (Record r; in.read(reinterpret_cast<char*>(&r.kind), sizeof r.kind);) {
    in.read(reinterpret_cast<char*>(&r.at_ns), sizeof r.at_ns);
    if (!read_text(in, r.topic) || !read_text(in, r.type) || !read_text(in, r.cdr))
      throw std::runtime_error(path + ": cut short");
    plan.push_back(r);
  }
  return plan;
}

class Out {
 public:
  explicit Out(const std::string& path) : out_(path, std::ios::binary) {}
  void write(const Record& r) {
    out_.write(reinterpret_cast<const char*>(&r.kind), sizeof r.kind);
    out_.write(reinterpret_cast<const char*>(&r.at_ns), sizeof r.at_ns);
    write_text(out_, r.topic);
    write_text(out_, r.type);
    write_text(out_, r.cdr);
    out_.flush();  // for who reads along
  }

 private:
  std::ofstream out_;
};

// ---- a type whose messages are the bytes ----

class RawType : public TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 1024;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<Bytes*>(data);
    payload->reserve(static_cast<std::uint32_t>(bytes.size()));
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    return true;
  }
  bool deserialize(SerializedPayload_t*, void*) override { return false; }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, InstanceHandle_t*, bool) override { return false; }
};

// ---- the participant ----

class Peer {
 public:
  Peer(std::uint32_t domain, const std::string& out) : out_(out) {
    auto* factory = DomainParticipantFactory::get_instance();
    participant_ = factory->create_participant(domain, PARTICIPANT_QOS_DEFAULT);
    if (!participant_) throw std::runtime_error("no participant");
    publisher_ = participant_->create_publisher(PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  }
  ~Peer() {
    participant_->delete_contained_entities();
    DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  void subscribe(const std::string& topic, const std::string& type, char quality) {
    DataReaderQos qos = DATAREADER_QOS_DEFAULT;
    qos.reliability().kind =
        quality == 'b' ? BEST_EFFORT_RELIABILITY_QOS : RELIABLE_RELIABILITY_QOS;
    qos.durability().kind =
        quality == 't' ? TRANSIENT_LOCAL_DURABILITY_QOS : VOLATILE_DURABILITY_QOS;
    qos.history().kind = KEEP_ALL_HISTORY_QOS;
    qos.resource_limits().max_samples = 0;  // no limit
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::DYNAMIC_RESERVE_MEMORY_MODE;
    const TypeSupport support = make_type(type);
    DataReader* reader = subscriber_->create_datareader(topic_of(topic, support), qos);
    if (!reader) throw std::runtime_error(topic + ": no reader");
    readers_.push_back({topic, type, support, reader, support->createData()});
  }

  // Makes the publishers of a plan.
  void advertise(const std::vector<Record>& plan) {
    for (const Record& r : plan) {
      const Key key{r.kind, r.topic, r.type};
      if (writers_.count(key)) continue;
      const TypeSupport support =
          r.kind == 0 ? make_type(r.type) : TypeSupport(new RawType(r.type));
      DataWriterQos qos = DATAWRITER_QOS_DEFAULT;
      qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
      qos.reliability().max_blocking_time = {10, 0};
      qos.history().kind = KEEP_ALL_HISTORY_QOS;
      qos.resource_limits().max_samples = 0;
      qos.resource_limits().max_samples_per_instance = 0;
      qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::DYNAMIC_RESERVE_MEMORY_MODE;
      DataWriter* writer = publisher_->create_datawriter(topic_of(r.topic, support), qos);
      if (!writer) throw std::runtime_error(r.topic + ": no writer");
      writers_[key] = {support, writer, support->createData()};
    }
  }

  bool matched() {
    for (const Reader& reader : readers_) {
      SubscriptionMatchedStatus status;
      reader.reader->get_subscription_matched_status(status);
      if (status.current_count == 0) return false;
    }
    for (const auto& [key, writer] : writers_) {
      PublicationMatchedStatus status;
      writer.writer->get_publication_matched_status(status);
      if (key.kind == 0 && status.current_count == 0) return false;
    }
    return true;
  }

  void send(const Record& r) {
    Writer& writer = writers_.at({r.kind, r.topic, r.type});
    if (r.kind == 1) {
      *static_cast<Bytes*>(writer.data) = r.cdr;
    } else {
      SerializedPayload_t payload(static_cast<std::uint32_t>(r.cdr.size()));
      std::memcpy(payload.data, r.cdr.data(), r.cdr.size());
      payload.length = static_cast<std::uint32_t>(r.cdr.size());
      if (!writer.support->deserialize(&payload, writer.data))
        throw std::runtime_error(r.type + ": Fast DDS cannot read the plan's bytes");
    }
    out_.write({0, now_ns(), r.topic, r.type, {}});
    if (!writer.writer->write(writer.data)) ++unsent;
  }

  // Takes what has come; whether there was anything.
  bool receive() {
    bool any = false;
    for (Reader& reader : readers_) {
      SampleInfo info;
      while (reader.reader->take_next_sample(reader.data, &info) == ReturnCode_t::RETCODE_OK) {
        if (!info.valid_data) continue;
        any = true;
        SerializedPayload_t payload(reader.support->getSerializedSizeProvider(reader.data)());
        if (!reader.support->serialize(reader.data, &payload))
          throw std::runtime_error(reader.type + ": Fast DDS cannot write what it has read");
        out_.write({1, now_ns(), reader.topic, reader.type,
                    Bytes(payload.data, payload.data + payload.length)});
      }
    }
    return any;
  }

  // Until all is with its subscribers.
  void finish() {
    for (const auto& [key, writer] : writers_)
      if (key.kind == 0) writer.writer->wait_for_acknowledgments({10, 0});
  }

  std::size_t unsent = 0;

 private:
  struct Key {
    std::uint8_t kind;
    std::string topic, type;
    bool operator<(const Key& o) const {
      return std::tie(kind, topic, type) < std::tie(o.kind, o.topic, o.type);
    }
  };
  struct Writer {
    TypeSupport support;
    DataWriter* writer;
    void* data;
  };
  struct Reader {
    std::string topic, type;
    TypeSupport support;
    DataReader* reader;
    void* data;
  };

  Topic* topic_of(const std::string& name, TypeSupport support) {
    support.register_type(participant_);
    if (auto* known = participant_->lookup_topicdescription(name)) {
      if (known->get_type_name() != support->getName())
        throw std::runtime_error(name + ": one peer has one type for a topic");
      return static_cast<Topic*>(known);
    }
    return participant_->create_topic(name, support->getName(), TOPIC_QOS_DEFAULT);
  }

  Out out_;
  DomainParticipant* participant_ = nullptr;
  Publisher* publisher_ = nullptr;
  Subscriber* subscriber_ = nullptr;
  std::map<Key, Writer> writers_;
  std::vector<Reader> readers_;
};

void run(int argc, char** argv) {
  if (argc < 3) throw std::runtime_error("usage: peer PLAN OUT [OPTIONS]");
  std::uint32_t domain = 0;
  double quiet_s = 2.0;
  std::vector<std::vector<std::string>> subscriptions;
  for (int i = 3; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--type-objects") {
      announce_type_objects();
    } else if (option == "--domain" && i + 1 < argc) {
      domain = std::stoul(argv[++i]);
    } else if (option == "--quiet-s" && i + 1 < argc) {
      quiet_s = std::stod(argv[++i]);
    } else if (option == "--subscribe" && i + 3 < argc) {
      subscriptions.push_back({argv[i + 1], argv[i + 2], argv[i + 3]});
      i += 3;
    } else {
      throw std::runtime_error("not understood: " + option);
    }
  }
  const auto plan = read_plan(argv[1]);
  Peer peer(domain, argv[2]);
  for (const auto& s : subscriptions) peer.subscribe(s[0], s[1], s[2].front());
  peer.advertise(plan);
  const auto pause = [] { std::this_thread::sleep_for(std::chrono::microseconds(200)); };
  const std::int64_t begun = now_ns();
  while (!peer.matched() && !ended) {
    if (now_ns() - begun > 30'000'000'000) throw std::runtime_error("not matched within 30 s");
    pause();
  }
  std::puts("matched");
  std::fflush(stdout);
  pollfd told{0, POLLIN, 0};
  while (poll(&told, 1, 0) == 0 && !ended)
    if (!peer.receive()) pause();
  const std::int64_t start = now_ns();
  for (const Record& r : plan) {
    do {
      if (!peer.receive() && now_ns() - start < r.at_ns) pause();
    } while (now_ns() - start < r.at_ns && !ended);
    if (ended) break;
    peer.send(r);
  }
  std::puts("sent");
  std::fflush(stdout);
  for (std::int64_t last = now_ns(); now_ns() - last < quiet_s * 1e9 && !ended; pause())
    if (peer.receive()) last = now_ns();
  peer.finish();
  if (peer.unsent > 0) throw std::runtime_error(std::to_string(peer.unsent) + " not sent");
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGTERM, [](int) { ended = true; });
  try {
    run(argc, argv);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "peer: " << error.what() << "\n";
    return 1;
  }
}
