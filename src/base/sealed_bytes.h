// Serialises numbers to bytes and back, with a header and a checksum that detect incomplete files.
// In the byte order of the machine (little-endian), which also reads the file again.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace gprodom {

class ByteWriter {
 public:
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    put_all(&value, 1);
  }
  template <typename T>
  void put_all(const T* values, std::size_t count) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }
  template <typename Values>
  void put_all(const Values& values) {
    put_all(values.data(), static_cast<std::size_t>(values.size()));
  }

  void put_text(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size()));
    put_all(text);
  }

  // The bytes of all put() calls, after a title, their length and a checksum.
  std::string sealed(const std::string& title) const;
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

// FNV-1a over words of eight bytes. Detects truncated or half-written files, not manipulation.
std::uint64_t checksum(std::string_view bytes);

class ByteReader {
 public:
  // Throws FileError("NAME: ...") where the bytes are not whole or have another title. They must
  // outlive the reader.
  ByteReader(const std::string& name, std::string_view sealed, const std::string& title);

  template <typename T>
  T get() {
    T value;
    get_all(&value, 1);
    return value;
  }
  template <typename T>
  void get_all(T* values, std::size_t count) {
    static_assert(std::is_arithmetic_v<T>);
    need(count, sizeof(T));
    if (count > 0) std::memcpy(values, bytes_.data(), count * sizeof(T));
    bytes_.remove_prefix(count * sizeof(T));
  }
  template <typename Values>
  void get_all(Values& values) {  // as many as it has
    get_all(values.data(), static_cast<std::size_t>(values.size()));
  }
  std::string get_text() {
    const auto size = get<std::uint32_t>();
    need(size, 1);
    std::string text(size, '\0');
    get_all(text);
    return text;
  }
  // Call before allocating memory for that many elements: throws if the file does not hold them.
  void need(std::size_t count, std::size_t size) const;
  void expect_end() const;

  std::uint64_t checksum() const { return checksum_; }  // of all that follows the header

  // Throws FileError with the file's name.
  [[noreturn]] void refuse(const std::string& why) const;

 private:
  std::string name_;
  std::string_view bytes_;
  std::uint64_t checksum_ = 0;
};

}  // namespace gprodom
