#include "io/log_io.h"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdio>

#include "gprodom/error.h"

namespace gprodom {
namespace {

constexpr std::uint32_t kSyncWord = 0xEDA1DA01;  // begins each event of a log
constexpr std::int64_t kHeaderBytes = 28;        // of an event, before its channel and data

}  // namespace

LogReader::LogReader(const std::string& path) : path_(path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) fail(path, "cannot be read");
  if (!S_ISREG(info.st_mode)) throw FileError(path + ": expected an LCM log, got no regular file");
  size_ = info.st_size;
  log_ = std::make_unique<lcm::LogFile>(path, "r");
  if (!log_->good()) fail(path, "cannot be read");
  if (size_ < kHeaderBytes || find_event(0) != 0)
    throw FileError(path + ": expected an LCM log, got something else");
}

// Byte of the first sync word at or behind `from`, or the file's size; the file is then read from
// there on.
std::int64_t LogReader::find_event(std::int64_t from) {
  FILE* file = log_->getFilePtr();
  std::clearerr(file);
  std::int64_t found = size_;
  if (fseeko(file, from, SEEK_SET) == 0) {
    std::uint32_t word = 0;
    std::int64_t read = 0;
    for (int byte = std::fgetc(file); byte != EOF; byte = std::fgetc(file)) {
      word = word << 8 | static_cast<std::uint32_t>(byte);
      if (++read >= 4 && word == kSyncWord) {
        found = from + read - 4;
        break;
      }
    }
  }
  fseeko(file, found, SEEK_SET);
  return found;
}

// Whether the event at position_ lies inside the file, by the lengths in its header. The library
// would allocate memory for these lengths without a check.
bool LogReader::event_fits() const {
  std::array<std::uint8_t, kHeaderBytes> header{};
  const auto read = pread(fileno(log_->getFilePtr()), header.data(), header.size(), position_);
  const auto length_at = [&](std::size_t at) {
    std::uint32_t length = 0;  // big-endian
    for (std::size_t i = at; i < at + 4; ++i) length = length << 8 | header[i];
    return std::int64_t{length};
  };
  return read == kHeaderBytes && length_at(20) + length_at(24) <= size_ - position_ - kHeaderBytes;
}

void LogReader::note_damage(std::int64_t from, std::int64_t to) {
  std::string line =
      path_ + ": event " + std::to_string(events_) + " (byte " + std::to_string(from) + "): ";
  line += to >= size_ ? "cut off or damaged from here to the end; the events before it are used"
                      : "damaged; the events before it, and from byte " + std::to_string(to) +
                            " on, are used";
  damage_.push_back(line);
}

const lcm::LogEvent* LogReader::next() {
  const std::int64_t start = position_;
  std::int64_t damaged_to = start;
  while (position_ < size_) {
    const lcm::LogEvent* event = event_fits() ? log_->readNextEvent() : nullptr;
    if (event) {
      if (damaged_to > start) note_damage(start, damaged_to);
      // The file's own position is of no use here, because the library reads ahead.
      position_ += kHeaderBytes + static_cast<std::int64_t>(event->channel.size()) + event->datalen;
      ++events_;
      return event;
    }
    damaged_to = position_ = find_event(position_ + 1);
  }
  if (damaged_to > start) note_damage(start, size_);
  return nullptr;
}

double LogReader::progress() const {
  return size_ > 0 ? static_cast<double>(position_) / static_cast<double>(size_) : 1.0;
}

LogWriter::LogWriter(const std::string& path) : file_(path) {
  log_ = std::make_unique<lcm::LogFile>(file_.working_path(), "w");
  if (!log_->good()) fail(path, "cannot be written");
}

void LogWriter::write(const LcmMessage& message) {
  lcm::LogEvent event{};
  event.timestamp = message.utime;
  event.channel = message.channel;
  event.datalen = static_cast<std::int32_t>(message.data.size());
  // The library's event is not const, but is only read from.
  event.data = const_cast<std::uint8_t*>(message.data.data());
  if (log_->writeEvent(&event) != 0) fail(file_.path(), "cannot be written");
}

void LogWriter::close() {
  FILE* file = log_->getFilePtr();
  if (std::fflush(file) != 0 || std::ferror(file)) fail(file_.path(), "cannot be written");
  log_.reset();
  file_.put_in_place();
}

}  // namespace gprodom
