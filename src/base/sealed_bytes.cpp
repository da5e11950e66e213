#include "base/sealed_bytes.h"

#include "gprodom/error.h"

namespace gprodom {

std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t sum = 14695981039346656037U;
  while (!bytes.empty()) {
    std::uint64_t word = 0;
    const std::size_t count = std::min(bytes.size(), sizeof word);
    std::memcpy(&word, bytes.data(), count);
    sum = (sum ^ word) * 1099511628211U;
    bytes.remove_prefix(count);
  }
  return sum;
}

std::string ByteWriter::sealed(const std::string& title) const {
  const std::uint64_t head[2] = {bytes_.size(), checksum(bytes_)};
  std::string all = title + "\n";
  all.reserve(all.size() + sizeof head + bytes_.size());
  all.append(reinterpret_cast<const char*>(head), sizeof head);
  return all + bytes_;
}

ByteReader::ByteReader(const std::string& name, std::string_view sealed, const std::string& title)
    : name_(name), bytes_(sealed) {
  const std::string first = title + "\n";
  if (bytes_.substr(0, first.size()) != first)
    refuse("expected it to begin with \"" + title + "\"");
  bytes_.remove_prefix(first.size());
  const auto length = get<std::uint64_t>();
  checksum_ = get<std::uint64_t>();
  if (bytes_.size() != length) refuse("it is cut off, or longer than it says");
  if (gprodom::checksum(bytes_) != checksum_) refuse("it is damaged: its checksum does not agree");
}

void ByteReader::need(std::size_t count, std::size_t size) const {
  if (count > bytes_.size() / size) refuse("it ends too early");
}

void ByteReader::expect_end() const {
  if (!bytes_.empty()) refuse("it holds more than it should");
}

void ByteReader::refuse(const std::string& why) const {
  throw FileError(name_ + ": cannot be used: " + why);
}

}  // namespace gprodom
