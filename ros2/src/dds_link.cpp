#include "dds_link.h"

#include <array>
#include <stdexcept>

namespace gprodom::ros2 {
namespace {

constexpr dds_duration_t kWait = DDS_MSECS(100);
// Of a topic, whose messages are numbered at once: more than a robot has sensors. A participant
// that makes new ones without end must not fill the memory.
constexpr std::size_t kMostPublishers = 1000;

dds_entity_t checked(dds_entity_t entity, const std::string& what) {
  if (entity < 0) throw std::runtime_error(what + ": " + dds_strretcode(entity));
  return entity;
}

// On the loopback, which says that it cannot multicast and yet can; with the ports tried one by
// one, too, since not every other node on this machine listens to multicast there.
std::string configuration(const std::string& interface) {
  const bool is_address = interface.find_first_not_of("0123456789.") == std::string::npos;
  const bool loopback = interface == "lo" || interface.rfind("127.", 0) == 0;
  std::string text = "<CycloneDDS><Domain><General><Interfaces><NetworkInterface ";
  text += (is_address ? "address=\"" : "name=\"") + interface + "\"";
  text += loopback ? " multicast=\"true\"" : "";
  text += "/></Interfaces></General>";
  if (loopback) {
    text +=
        "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
        "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
        "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery>";
  }
  // Messages not yet acknowledged, before a writer has to wait, which ours never do: room for
  // `depth` of the usual ones, and not less because some subscriber is slow.
  text += "<Internal><Watermarks><WhcAdaptive>false</WhcAdaptive>";
  text += "<WhcHigh>16 MB</WhcHigh></Watermarks></Internal>";
  return text + "</Domain></CycloneDDS>";
}

using Qos = std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)>;

Qos make_qos(const Quality& quality) {
  Qos qos(dds_create_qos(), dds_delete_qos);
  dds_qset_reliability(
      qos.get(), quality.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, quality.depth);
  if (quality.for_late_subscribers) {
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, quality.depth,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  return qos;
}

}  // namespace

DdsLink::DdsLink(const Settings& settings, OnRefused on_refused)
    : settings_(settings), on_refused_(std::move(on_refused)) {
  const auto id = static_cast<dds_domainid_t>(settings.domain);
  const std::string where =
      "DDS on interface '" + settings.interface + "', domain " + std::to_string(settings.domain);
  if (!settings.interface.empty())
    domain_ = checked(dds_create_domain(id, configuration(settings.interface).c_str()),
                      where + " (does the interface exist, is it up?)");
  try {
    Qos qos(dds_create_qos(), dds_delete_qos);
    const std::string enclave = "enclave=/;";  // by which ROS 2 knows its own participants
    dds_qset_userdata(qos.get(), enclave.data(), enclave.size());
    participant_ = checked(dds_create_participant(id, qos.get(), nullptr), where);
    waitset_ = checked(dds_create_waitset(participant_), where);
    publishers_ = checked(
        dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
        where);
    const dds_entity_t any = dds_create_readcondition(publishers_, DDS_ANY_STATE);
    checked(dds_waitset_attach(waitset_, any, 0), where);
  } catch (...) {
    dds_delete(domain_ > 0 ? domain_ : participant_);
    throw;
  }
}

DdsLink::~DdsLink() { dds_delete(domain_ > 0 ? domain_ : participant_); }

void DdsLink::subscribe(const std::string& topic, const std::string& type, const Quality& quality,
                        Take take) {
  const std::string wire_name = on_the_wire(settings_, topic);
  const RawTopic made = create_raw_topic(participant_, wire_name, type);
  const dds_entity_t reader =
      checked(dds_create_reader(participant_, made.topic, make_qos(quality).get(), nullptr), topic);
  subscriptions_.push_back({topic, wire_name, type, std::move(take), reader, Counts(), {}});
  const dds_entity_t any = dds_create_readcondition(reader, DDS_ANY_STATE);
  checked(dds_waitset_attach(waitset_, any, reinterpret_cast<dds_attach_t>(&subscriptions_.back())),
          topic);
}

Publication DdsLink::publish(const std::string& topic, const std::string& type,
                             const Quality& quality) {
  const RawTopic made = create_raw_topic(participant_, on_the_wire(settings_, topic), type);
  const dds_entity_t writer =
      dds_create_writer(participant_, made.topic, make_qos(quality).get(), nullptr);
  return {checked(writer, topic), made.type};
}

void DdsLink::receive() {
  std::array<dds_attach_t, 16> ready;
  const dds_return_t count = dds_waitset_wait(waitset_, ready.data(), ready.size(), kWait);
  for (dds_return_t i = 0; i < std::min<dds_return_t>(count, ready.size()); ++i) {
    if (ready[i] == 0)
      watch_publishers();
    else
      take(*reinterpret_cast<Subscription*>(ready[i]));
  }
}

void DdsLink::take(Subscription& subscription) {
  Counts& counts = subscription.counts;
  take_raw(subscription.reader,
           [&](const std::uint8_t* cdr, std::size_t size, const Origin& origin) {
             count(subscription, origin);
             try {
               subscription.take(cdr, size);
             } catch (const CdrError& error) {
               ++counts.refused;
               on_refused_(subscription.topic, std::string("message ") + error.what());
             }
           });
}

// Cyclone DDS itself counts no message that a best-effort publisher sent in vain.
void DdsLink::count(Subscription& subscription, const Origin& origin) {
  ++subscription.counts.received;
  if (subscription.last.size() >= kMostPublishers) subscription.last.clear();
  const auto [known, first] = subscription.last.try_emplace(origin.publisher, origin.number);
  if (!first && origin.number > known->second)
    subscription.counts.lost += static_cast<std::uint64_t>(origin.number - known->second - 1);
  known->second = origin.number;
}

// A publisher of another type is matched with none of our subscriptions, so nothing else tells of
// it.
void DdsLink::watch_publishers() {
  std::array<void*, 16> samples{};
  std::array<dds_sample_info_t, 16> infos;
  for (;;) {
    const dds_return_t count =
        dds_take(publishers_, samples.data(), infos.data(), samples.size(), samples.size());
    for (dds_return_t i = 0; i < count; ++i) {
      const auto& found = *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
      if (!infos[i].valid_data || infos[i].instance_state != DDS_IST_ALIVE) continue;
      for (Subscription& subscription : subscriptions_) {
        if (subscription.wire_name != found.topic_name || subscription.type == found.type_name)
          continue;
        ++subscription.counts.other_types;
        on_refused_(subscription.topic, "publisher of another type, expected " + subscription.type);
      }
    }
    if (count > 0) dds_return_loan(publishers_, samples.data(), count);
    if (count < static_cast<dds_return_t>(samples.size())) return;
  }
}

std::vector<std::pair<std::string, Counts>> DdsLink::counts() const {
  std::vector<std::pair<std::string, Counts>> all;
  for (const Subscription& subscription : subscriptions_) {
    Counts counts = subscription.counts;
    dds_subscription_matched_status_t matched{};
    dds_requested_incompatible_qos_status_t incompatible{};
    dds_get_subscription_matched_status(subscription.reader, &matched);
    dds_get_requested_incompatible_qos_status(subscription.reader, &incompatible);
    counts.publishers = matched.current_count;
    counts.incompatible = incompatible.total_count;
    all.emplace_back(subscription.topic, counts);
  }
  return all;
}

}  // namespace gprodom::ros2
