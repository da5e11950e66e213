// Messages as packets, for tests of what reads them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace gprodom {

using Bytes = std::vector<std::uint8_t>;

template <class Message>
Bytes encoded(const Message& message) {
  Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace gprodom
