// Walks over an encoded LCM message and checks that everything lies within it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace gprodom {

// Call the members in the order of the type's fields, then end(). After the first fault, which is
// kept, nothing more is read. Only the text of a fault allocates memory.
class PacketLayout {
 public:
  // Checks the type's fingerprint.
  PacketLayout(const void* data, std::size_t size, std::int64_t fingerprint);

  // Fields of fixed size, `bytes` together.
  PacketLayout& fixed(std::size_t bytes);

  // An int32 count of elements that follow later; 0 after a fault.
  std::size_t count(const char* name, std::size_t max_elements);

  // An int32 count and, right behind it, that many elements.
  PacketLayout& counted_array(const char* name, std::size_t element_bytes,
                              std::size_t max_elements);

  // An int32 length that counts the closing zero, and as many bytes.
  PacketLayout& string(const char* name);

  // Checks that no bytes are left. Returns the fault; empty if there is none. Faults of one kind
  // have the same text whatever the packet holds, because they are counted by their text.
  std::string end();

 private:
  bool take(std::size_t bytes, const std::string& what);
  std::int32_t peek_int32() const;

  const std::uint8_t* next_;
  std::size_t left_;
  std::string fault_;
};

}  // namespace gprodom
