// A saved file's title and contents, without the length and the checksum between them: those would
// let nothing that is changed through. A file that is not sealed right is tried too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/sealed_bytes.h"
#include "gprodom/error.h"

// Of a saved file: what its reader wants it to begin with.
inline std::string title_of(const std::string& sealed) {
  return sealed.substr(0, sealed.find('\n'));
}

// Calls read(bytes) with the bytes as they are, and as the contents of a sound file.
template <typename Read>
int read_sealed(const std::string& title, const std::uint8_t* data, std::size_t size, Read read) {
  gprodom::ByteWriter contents;
  contents.put_all(data, size);
  const std::string raw(reinterpret_cast<const char*>(data), size);
  for (const std::string& bytes : {raw, contents.sealed(title)}) {
    try {
      read(bytes);
    } catch (const gprodom::FileError&) {
    }
  }
  return 0;
}
