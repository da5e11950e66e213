#include "raw_type.h"

#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_protocol.h>
#include <dds/ddsi/q_radmin.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>

#include "cdr.h"

namespace gprodom::ros2 {
namespace {

struct Message : ddsi_serdata {
  std::vector<std::uint8_t> bytes;  // filled up to a multiple of 4, to which DDS reads
  std::size_t size = 0;
  std::int64_t number = 0;  // that its publisher gave it
};

const Message& message_of(const ddsi_serdata* data) { return *static_cast<const Message*>(data); }

Message* new_message(const ddsi_sertype* type, ddsi_serdata_kind kind, std::size_t size) {
  auto* message = new Message;
  ddsi_serdata_init(message, type, kind);
  message->hash = type->serdata_basehash;
  message->size = size;
  message->bytes.resize((size + 3) / 4 * 4);
  return message;
}

ddsi_serdata* new_key(const ddsi_sertype* type) { return new_message(type, SDK_KEY, 0); }

// ---- one message; the names are those of ddsi_serdata_ops ----

std::uint32_t get_size(const ddsi_serdata* data) {
  return static_cast<std::uint32_t>(message_of(data).size);
}

// The packet holds it in the byte order of this machine: Cyclone DDS has turned it.
std::int64_t number_of(const nn_rdata* fragment) {
  Data_DataFrag_common_t head;
  std::memcpy(&head, NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_SUBMSG_OFF(fragment)),
              sizeof head);
  return static_cast<std::int64_t>(head.writerSN.high) << 32 | head.writerSN.low;
}

// Of fragments, which may overlap, in order.
ddsi_serdata* from_ser(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragments,
                       std::size_t size) {
  if (kind != SDK_DATA) return new_key(type);
  Message* message = new_message(type, kind, size > kMaxMessage ? 0 : size);
  message->number = number_of(fragments);
  std::uint32_t end = 0;
  for (const nn_rdata* f = fragments; f; f = f->nextfrag) {
    const std::uint32_t from = std::max(end, f->min);
    const std::uint32_t to = std::min(f->maxp1, static_cast<std::uint32_t>(message->size));
    if (to <= from) continue;
    const unsigned char* payload = NN_RMSG_PAYLOADOFF(f->rmsg, NN_RDATA_PAYLOAD_OFF(f));
    std::memcpy(message->bytes.data() + from, payload + (from - f->min), to - from);
    end = to;
  }
  return message;
}

ddsi_serdata* from_ser_iov(const ddsi_sertype* type, ddsi_serdata_kind kind,
                           ddsrt_msg_iovlen_t count, const ddsrt_iovec_t* parts, std::size_t size) {
  if (kind != SDK_DATA) return new_key(type);
  if (size > kMaxMessage) return new_message(type, kind, 0);
  Message* message = new_message(type, kind, size);
  std::size_t at = 0;
  for (ddsrt_msg_iovlen_t i = 0; i < count && at < size; ++i) {
    const std::size_t part = std::min<std::size_t>(parts[i].iov_len, size - at);
    std::memcpy(message->bytes.data() + at, parts[i].iov_base, part);
    at += part;
  }
  return message;
}

void to_ser(const ddsi_serdata* data, std::size_t offset, std::size_t size, void* to) {
  std::memcpy(to, message_of(data).bytes.data() + offset, size);
}

ddsi_serdata* to_ser_ref(const ddsi_serdata* data, std::size_t offset, std::size_t size,
                         ddsrt_iovec_t* reference) {
  reference->iov_base = const_cast<std::uint8_t*>(message_of(data).bytes.data() + offset);
  reference->iov_len = size;
  return ddsi_serdata_ref(data);
}

const ddsi_serdata_ops kMessageOps = [] {
  ddsi_serdata_ops ops{};
  ops.eqkey = [](const ddsi_serdata*, const ddsi_serdata*) { return true; };  // there is no key
  ops.get_size = get_size;
  ops.from_ser = from_ser;
  ops.from_ser_iov = from_ser_iov;
  ops.from_keyhash = [](const ddsi_sertype* type, const ddsi_keyhash*) { return new_key(type); };
  // Samples are never made: messages come and go as bytes.
  ops.from_sample = [](const ddsi_sertype*, ddsi_serdata_kind, const void*) -> ddsi_serdata* {
    return nullptr;
  };
  ops.to_ser = to_ser;
  ops.to_ser_ref = to_ser_ref;
  ops.to_ser_unref = [](ddsi_serdata* data, const ddsrt_iovec_t*) { ddsi_serdata_unref(data); };
  ops.to_sample = [](const ddsi_serdata*, void*, void**, void*) { return false; };
  ops.to_untyped = [](const ddsi_serdata* data) { return new_key(data->type); };
  ops.untyped_to_sample = [](const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) {
    return false;
  };
  ops.free = [](ddsi_serdata* data) { delete static_cast<Message*>(data); };
  ops.print = [](const ddsi_sertype*, const ddsi_serdata*, char* text, std::size_t size) {
    if (size > 0) text[0] = 0;
    return std::size_t{0};
  };
  ops.get_keyhash = [](const ddsi_serdata*, ddsi_keyhash* hash, bool) {
    std::memset(hash, 0, sizeof *hash);
  };
  return ops;
}();

// ---- the type; the names are those of ddsi_sertype_ops ----

const ddsi_sertype_ops kTypeOps = [] {
  ddsi_sertype_ops ops{};
  ops.version = ddsi_sertype_v0;
  ops.free = [](ddsi_sertype* type) {
    ddsi_sertype_fini(type);
    delete type;
  };
  ops.zero_samples = [](const ddsi_sertype*, void*, std::size_t) {};
  ops.realloc_samples = [](void** made, const ddsi_sertype*, void*, std::size_t, std::size_t) {
    *made = nullptr;
  };
  ops.free_samples = [](const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {};
  ops.equal = [](const ddsi_sertype*, const ddsi_sertype*) { return true; };  // by name already
  ops.hash = [](const ddsi_sertype*) { return std::uint32_t{0}; };
  return ops;
}();

}  // namespace

RawTopic create_raw_topic(dds_entity_t participant, const std::string& name,
                          const std::string& type) {
  auto* made = new ddsi_sertype{};
  ddsi_sertype_init(made, type.c_str(), &kTypeOps, &kMessageOps, true);
  made->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  ddsi_sertype* used = made;  // or one of the same name that there is already
  const dds_entity_t topic =
      dds_create_topic_sertype(participant, name.c_str(), &used, nullptr, nullptr, nullptr);
  if (topic < 0) {
    ddsi_sertype_unref(made);
    throw std::runtime_error("topic " + name + " cannot be made: " + dds_strretcode(topic));
  }
  return {topic, used};
}

bool write_raw(dds_entity_t writer, const ddsi_sertype* type,
               const std::vector<std::uint8_t>& cdr) {
  Message* message = new_message(type, SDK_DATA, cdr.size());
  std::copy(cdr.begin(), cdr.end(), message->bytes.begin());
  return dds_writecdr(writer, message) == DDS_RETCODE_OK;  // which takes the message over
}

void take_raw(dds_entity_t reader,
              const std::function<void(const std::uint8_t* cdr, std::size_t size,
                                       const Origin& origin)>& take) {
  constexpr std::uint32_t kAtOnce = 64;
  std::array<ddsi_serdata*, kAtOnce> taken{};
  std::array<dds_sample_info_t, kAtOnce> infos;
  for (;;) {
    const dds_return_t count =
        dds_takecdr(reader, taken.data(), kAtOnce, infos.data(), DDS_ANY_STATE);
    for (dds_return_t i = 0; i < count; ++i) {
      const Message& message = message_of(taken[i]);
      const Origin origin{infos[i].publication_handle, message.number};
      if (infos[i].valid_data) take(message.bytes.data(), message.size, origin);
      ddsi_serdata_unref(taken[i]);
    }
    if (count < static_cast<dds_return_t>(kAtOnce)) return;
  }
}

}  // namespace gprodom::ros2
