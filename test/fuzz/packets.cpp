// A packet of any channel, as it comes from the network: the first byte chooses the channel.
#include "gprodom/lcm_io.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  static const gprodom::ChannelConfig channels;
  static const std::vector<std::string> names = gprodom::input_channels(channels);
  gprodom::decode_input(channels, names[data[0] % names.size()], data + 1, size - 1);
  return 0;
}
