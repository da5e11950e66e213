// A configuration file.
#include "gprodom/config.h"

#include "bytes_as_file.h"
#include "gprodom/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const BytesAsFile file(data, size);
  try {
    gprodom::load_config({file.path()});
  } catch (const gprodom::ConfigError&) {  // by which a file that is wrong is refused
  }
  return 0;
}
