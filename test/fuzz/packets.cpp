// A packet of any channel, as it comes from the network: the first byte chooses the channel.
#include "gprodom/lcm_io.h"
#include "io/status_instance.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  static const gprodom::ChannelConfig channels;
  static const std::vector<std::string> names = gprodom::input_channels(channels);
  const std::size_t chosen = data[0] % (names.size() + 1);
  if (chosen == names.size())
    gprodom::instance_of(data + 1, size - 1);
  else
    gprodom::decode_input(channels, names[chosen], data + 1, size - 1);
  return 0;
}
