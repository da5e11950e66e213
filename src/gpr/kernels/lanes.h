// Loops over samples in blocks of four registers of 16 bytes, with the compiler's vector types.
// Every 64-bit processor has such registers, so no processor feature must be detected.
#pragma once

#include <cstring>

namespace gprodom::gpr {

template <typename T>
struct Lane {
  typedef T Type __attribute__((vector_size(16)));
  static constexpr int kSize = 16 / sizeof(T);
};

// Samples in a block.
template <typename T>
constexpr int kBlock = 4 * Lane<T>::kSize;

// `count` rounded up to whole blocks.
template <typename T>
constexpr int blocked(int count) {
  return (count + kBlock<T> - 1) / kBlock<T> * kBlock<T>;
}

// A running sum of kBlock<T> samples. Four named members, which stay in registers where an array
// would not at -O2.
template <typename T>
struct Block {
  typename Lane<T>::Type a{}, b{}, c{}, d{};

  // *this += factor * x[0 .. kBlock), x unaligned.
  void add(T factor, const T* x) {
    a += factor * load(x);
    b += factor * load(x + Lane<T>::kSize);
    c += factor * load(x + 2 * Lane<T>::kSize);
    d += factor * load(x + 3 * Lane<T>::kSize);
  }

  // *this += factor * (x[...] + y[...]).
  void add(T factor, const T* x, const T* y) {
    a += factor * (load(x) + load(y));
    b += factor * (load(x + Lane<T>::kSize) + load(y + Lane<T>::kSize));
    c += factor * (load(x + 2 * Lane<T>::kSize) + load(y + 2 * Lane<T>::kSize));
    d += factor * (load(x + 3 * Lane<T>::kSize) + load(y + 3 * Lane<T>::kSize));
  }

  void store(T* out) const {
    std::memcpy(out, &a, sizeof(a));
    std::memcpy(out + Lane<T>::kSize, &b, sizeof(b));
    std::memcpy(out + 2 * Lane<T>::kSize, &c, sizeof(c));
    std::memcpy(out + 3 * Lane<T>::kSize, &d, sizeof(d));
  }

 private:
  static typename Lane<T>::Type load(const T* x) {
    typename Lane<T>::Type value;
    std::memcpy(&value, x, sizeof(value));
    return value;
  }
};

}  // namespace gprodom::gpr
