// LCM messages to measurements, and estimates to LCM messages; nothing else.
//
// Packets come from the network and may hold anything. Each is measured against its type's layout
// before the generated decoder, which trusts counts and string lengths, may see it. Whether values
// make sense (NaN, a jump in time) is left to the estimator.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/export.h"
#include "gprodom/input.h"
#include "gprodom/outputs.h"
#include "gprodom/types.h"

namespace gprodom {

// An encoded message and the data time that it is of.
struct LcmMessage {
  std::int64_t utime = 0;  // us
  std::string channel;
  std::vector<std::uint8_t> data;
};

// The input in a packet, or a Rejection that says what is wrong with it; nothing for a channel that
// the daemon does not listen to.
GPRODOM_EXPORT std::optional<Input> decode_input(const ChannelConfig& channels,
                                                 const std::string& channel, const void* data,
                                                 std::size_t size);

// The channels that decode_input() knows.
GPRODOM_EXPORT std::vector<std::string> input_channels(const ChannelConfig& channels);

// What to publish of one step, ordered by time.
GPRODOM_EXPORT std::vector<LcmMessage> make_messages(const ChannelConfig& channels,
                                                     const Outputs& outputs);

}  // namespace gprodom
