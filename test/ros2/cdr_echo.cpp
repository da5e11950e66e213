// Reads messages as CDR and writes them again, for test_cdr.py. Input, again and again: the length
// of the type's name (uint32), the name, the size (uint32), the bytes. Answer to each: 1 and the
// size and bytes of the message written anew, or 0 and the size and text of what is wrong.
#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "cdr.h"
#include "messages.h"

namespace {

using namespace gprodom::ros2;
using Bytes = std::vector<std::uint8_t>;
using Echo = Bytes (*)(const Bytes&);

template <class Message>
Bytes echo(const Bytes& bytes) {
  return to_cdr(from_cdr<Message>(bytes.data(), bytes.size()));
}

template <class... Messages>
std::map<std::string, Echo> echoes() {
  return {{Messages::kType, echo<Messages>}...};
}

bool read(Bytes& bytes) {
  std::uint32_t size = 0;
  if (std::fread(&size, sizeof size, 1, stdin) != 1) return false;
  bytes.resize(size);
  return size == 0 || std::fread(bytes.data(), size, 1, stdin) == 1;
}

void write(char good, const std::uint8_t* bytes, std::size_t size) {
  const auto count = static_cast<std::uint32_t>(size);
  std::fputc(good, stdout);
  std::fwrite(&count, sizeof count, 1, stdout);
  if (size > 0) std::fwrite(bytes, size, 1, stdout);
}

}  // namespace

int main() {
  const auto known = echoes<Time, Header, Int64, Clock, Log, Vector3, Quaternion, Pose,
                            PoseWithCovariance, PoseWithCovarianceStamped, Twist, TwistStamped,
                            TwistWithCovariance, Transform, TransformStamped, TFMessage, Odometry,
                            Imu, NavSatStatus, NavSatFix, JointState, KeyValue, DiagnosticStatus,
                            DiagnosticArray, GprTraceMessage, Revisit, CommandMessage>();
  Bytes name, bytes;
  while (read(name) && read(bytes)) {
    try {
      const Bytes answer = known.at(std::string(name.begin(), name.end()))(bytes);
      write(1, answer.data(), answer.size());
    } catch (const CdrError& error) {
      const std::string text = error.what();
      write(0, reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    }
    std::fflush(stdout);
  }
}
