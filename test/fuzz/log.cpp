// An LCM log, read to its end, every packet in it decoded.
#include "bytes_as_file.h"
#include "gprodom/error.h"
#include "gprodom/lcm_io.h"
#include "io/log_io.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const BytesAsFile file(data, size);
  static const gprodom::ChannelConfig channels;
  try {
    gprodom::LogReader log(file.path());
    while (const lcm::LogEvent* event = log.next()) {
      gprodom::decode_input(channels, event->channel, event->data,
                            static_cast<std::size_t>(event->datalen));
    }
  } catch (const gprodom::FileError&) {
  }
  return 0;
}
