#include "io/status_instance.h"

#include <algorithm>
#include <string>

#include "gprodom/types.h"
#include "io/packet_layout.h"
#include "lcmtypes/gprodom/status_t.hpp"

namespace gprodom {
namespace {

constexpr std::size_t kMost = 10000;  // reasons or values; ours are some hundreds at most

std::string fault_of(const void* data, std::size_t size) {
  PacketLayout layout(data, size, status_t::getHash());
  layout.fixed(8 + 1);  // utime, health
  for (std::size_t reasons = layout.count("reasons", kMost); reasons > 0; --reasons)
    layout.string("reason");
  const std::size_t values = layout.count("values", kMost);
  for (std::size_t i = 0; i < values; ++i) layout.string("name");
  return layout.fixed(8 * values).end();
}

}  // namespace

std::optional<double> instance_of(const void* data, std::size_t size) {
  if (!fault_of(data, size).empty()) return std::nullopt;
  status_t status;
  if (status.decode(data, 0, static_cast<int>(size)) < 0) return std::nullopt;
  const auto found = std::find(status.names.begin(), status.names.end(), kInstance);
  if (found == status.names.end()) return 0.0;
  return status.values[static_cast<std::size_t>(found - status.names.begin())];
}

}  // namespace gprodom
