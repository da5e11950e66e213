// Messages as CDR, the bytes of DDS (XCDR version 1, final types): a header of four bytes, then
// every number at a multiple of its size from there on. Bytes come from the network and may hold
// anything, so the reader trusts no count and no length.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace gprodom::ros2 {

constexpr std::size_t kCdrHeader = 4;  // bytes: 0, whether little endian, and two of options
constexpr bool kLittleEndian = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__;

// Where a number of `size` bytes begins that comes after `position` bytes, the header included.
constexpr std::size_t aligned(std::size_t position, std::size_t size) {
  return kCdrHeader + (position - kCdrHeader + size - 1) / size * size;
}

class CdrWriter {
 public:
  template <class T>
  void operator()(const T& value) {
    if constexpr (std::is_arithmetic_v<T>) {
      const std::size_t at = aligned(bytes_.size(), sizeof(T));
      bytes_.resize(at + sizeof(T));
      std::memcpy(bytes_.data() + at, &value, sizeof(T));
    } else {
      T::fields(value, *this);
    }
  }
  void operator()(const std::string& text) {
    (*this)(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
  }
  template <class T>
  void operator()(const std::vector<T>& sequence) {
    (*this)(static_cast<std::uint32_t>(sequence.size()));
    for (const T& each : sequence) (*this)(each);
  }
  template <class T, std::size_t N>
  void operator()(const std::array<T, N>& array) {
    for (const T& each : array) (*this)(each);
  }

  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_{0, kLittleEndian, 0, 0};
};

// What is wrong with the bytes, as the rest of a sentence about the message: "is cut short".
struct CdrError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class CdrReader {
 public:
  CdrReader(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), size_(size) {
    if (size < kCdrHeader) throw CdrError("is cut short");
    if (bytes[0] != 0 || bytes[1] > 1) throw CdrError("is not in plain CDR");
    swapped_ = (bytes[1] == 1) != kLittleEndian;
  }

  template <class T>
  void operator()(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = 0;
      (*this)(byte);
      if (byte > 1) throw CdrError("has a truth value that is neither");
      value = byte == 1;
    } else if constexpr (std::is_arithmetic_v<T>) {
      position_ = aligned(position_, sizeof(T));
      need(sizeof(T));
      std::array<std::uint8_t, sizeof(T)> raw;
      std::copy_n(bytes_ + position_, sizeof(T), raw.begin());
      if (swapped_) std::reverse(raw.begin(), raw.end());
      std::memcpy(&value, raw.data(), sizeof(T));
      position_ += sizeof(T);
    } else {
      T::fields(value, *this);
    }
  }
  void operator()(std::string& text) {
    std::uint32_t size = 0;  // with the 0 at its end
    (*this)(size);
    need(size);
    if (size == 0 || bytes_[position_ + size - 1] != 0) throw CdrError("has a text without an end");
    text.assign(reinterpret_cast<const char*>(bytes_ + position_), size - 1);
    position_ += size;
  }
  template <class T>
  void operator()(std::vector<T>& sequence) {
    std::uint32_t count = 0;
    (*this)(count);
    if constexpr (std::is_arithmetic_v<T>) {
      if (count > (size_ - position_) / sizeof(T)) throw CdrError("has a count beyond its end");
      sequence.resize(count);
      for (T& each : sequence) (*this)(each);
    } else {  // grows with what is really there
      sequence.clear();
      for (std::uint32_t i = 0; i < count; ++i) (*this)(sequence.emplace_back());
    }
  }
  template <class T, std::size_t N>
  void operator()(std::array<T, N>& array) {
    for (T& each : array) (*this)(each);
  }

  // Nothing may be left but the bytes that fill up to a multiple of four.
  void end() const {
    if (size_ - position_ >= 4) throw CdrError("has bytes left over");
  }

 private:
  void need(std::size_t count) const {
    if (position_ > size_ || count > size_ - position_) throw CdrError("is cut short");
  }

  const std::uint8_t* bytes_;
  std::size_t size_, position_ = kCdrHeader;
  bool swapped_ = false;
};

template <class Message>
std::vector<std::uint8_t> to_cdr(const Message& message) {
  CdrWriter writer;
  writer(message);
  return writer.take();
}

// Throws CdrError.
template <class Message>
Message from_cdr(const std::uint8_t* bytes, std::size_t size) {
  Message message;
  CdrReader reader(bytes, size);
  reader(message);
  reader.end();
  return message;
}

}  // namespace gprodom::ros2
