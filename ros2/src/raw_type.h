// A DDS type of which Cyclone DDS knows the name alone: messages are handed over as the bytes that
// come from, or go to, the network. So what is wrong with a message is found, named and counted
// here, where Cyclone DDS would drop it with a line in its own log.
#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace gprodom::ros2 {

// Larger messages are not kept: the largest trace that is taken has 65536 samples of 4 bytes.
constexpr std::size_t kMaxMessage = 1 << 20;  // bytes

struct RawTopic {
  dds_entity_t topic = 0;
  const ddsi_sertype* type = nullptr;  // lives as long as the topic
};

// `type` as it is called on the wire. Throws std::runtime_error.
RawTopic create_raw_topic(dds_entity_t participant, const std::string& name,
                          const std::string& type);

// Writes a message with its CDR header. False where it could not be sent at once.
bool write_raw(dds_entity_t writer, const ddsi_sertype* type, const std::vector<std::uint8_t>& cdr);

// Whose a message is, and which of its messages: publishers number all that they send.
struct Origin {
  dds_instance_handle_t publisher = 0;
  std::int64_t number = 0;
};

// Takes what a reader has. Of a message of more than kMaxMessage, `take` gets no byte.
void take_raw(dds_entity_t reader,
              const std::function<void(const std::uint8_t* cdr, std::size_t size,
                                       const Origin& origin)>& take);

}  // namespace gprodom::ros2
