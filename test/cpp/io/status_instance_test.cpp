#include "io/status_instance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "gprodom/types.h"
#include "io/encoded.h"
#include "lcmtypes/gprodom/command_t.hpp"
#include "lcmtypes/gprodom/status_t.hpp"

namespace gprodom {
namespace {

status_t status_message(const std::vector<std::string>& names) {
  status_t m{};
  m.utime = 1700001000123456;
  m.reasons = {"WHEEL: no data for a second or more", ""};
  m.num_reasons = 2;
  m.names = names;
  for (std::size_t i = 0; i < names.size(); ++i)
    m.values.push_back(281474976710655.0 + static_cast<double>(i));
  m.num_values = static_cast<std::int32_t>(names.size());
  return m;
}

TEST(StatusInstance, IsReadFromAStatus) {
  const Bytes with = encoded(status_message({"states", kInstance}));
  EXPECT_EQ(instance_of(with.data(), with.size()), 281474976710656.0);
  const Bytes without = encoded(status_message({"states"}));
  EXPECT_EQ(instance_of(without.data(), without.size()), 0.0);
}

TEST(StatusInstance, IsNotReadFromOtherPackets) {
  const Bytes whole = encoded(status_message({"states", kInstance}));
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(instance_of(whole.data(), size).has_value()) << size;
  for (const std::uint8_t count : {0xffU, 0x7fU, 0x00U}) {  // of the reasons
    Bytes hostile = whole;
    std::fill_n(hostile.begin() + 17, 4, count);
    EXPECT_FALSE(instance_of(hostile.data(), hostile.size()).has_value());
  }
  const Bytes other = encoded(command_t{});
  EXPECT_FALSE(instance_of(other.data(), other.size()).has_value());
}

}  // namespace
}  // namespace gprodom
