#include "io/packet_layout.h"

#include <cstring>

namespace gprodom {
namespace {

constexpr std::size_t kMaxString = 4096;

std::uint64_t big_endian(const std::uint8_t* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[i];
  return value;
}

}  // namespace

PacketLayout::PacketLayout(const void* data, std::size_t size, std::int64_t fingerprint)
    : next_(static_cast<const std::uint8_t*>(data)), left_(size) {
  if (!take(8, "the type's fingerprint")) return;
  if (static_cast<std::int64_t>(big_endian(next_ - 8, 8)) != fingerprint) {
    fault_ = "is of another message type or version";
  }
}

bool PacketLayout::take(std::size_t bytes, const std::string& what) {
  if (!fault_.empty()) return false;
  if (bytes > left_) {
    fault_ = "ends within " + what;
    return false;
  }
  next_ += bytes;
  left_ -= bytes;
  return true;
}

std::int32_t PacketLayout::peek_int32() const {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(big_endian(next_ - 4, 4)));
}

PacketLayout& PacketLayout::fixed(std::size_t bytes) {
  take(bytes, "its fields");
  return *this;
}

std::size_t PacketLayout::count(const char* name, std::size_t max_elements) {
  if (!take(4, std::string("the count of ") + name)) return 0;
  const std::int32_t told = peek_int32();
  if (told < 0 || static_cast<std::size_t>(told) > max_elements) {
    fault_ = std::string("announces an impossible count of ") + name;
    return 0;
  }
  return static_cast<std::size_t>(told);
}

PacketLayout& PacketLayout::counted_array(const char* name, std::size_t element_bytes,
                                          std::size_t max_elements) {
  take(count(name, max_elements) * element_bytes, name);
  return *this;
}

PacketLayout& PacketLayout::string(const char* name) {
  if (!take(4, std::string("the length of ") + name)) return *this;
  const std::int32_t length = peek_int32();
  if (length < 1 || static_cast<std::size_t>(length) > kMaxString) {
    fault_ = std::string("announces an impossible length of ") + name;
    return *this;
  }
  const std::uint8_t* text = next_;
  const auto bytes = static_cast<std::size_t>(length);
  if (take(bytes, name) && std::memchr(text, 0, bytes) != text + bytes - 1) {
    fault_ = std::string("has a ") + name + " without its closing zero";
  }
  return *this;
}

std::string PacketLayout::end() {
  if (fault_.empty() && left_ > 0) fault_ = "has bytes left over";
  return fault_;
}

}  // namespace gprodom
