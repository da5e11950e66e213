// CDR that is not what it should be. That what is right has the right bytes is for test_cdr.py.
#include "cdr.h"

#include <gtest/gtest.h>

#include "messages.h"

namespace gprodom::ros2 {
namespace {

template <class Message>
std::string fault_of(const std::vector<std::uint8_t>& bytes) {
  try {
    from_cdr<Message>(bytes.data(), bytes.size());
  } catch (const CdrError& error) {
    return error.what();
  }
  return "";
}

GprTraceMessage trace() {
  GprTraceMessage m;
  m.header.frame_id = "antenna";
  m.samples = {1, -2, 3, 4, 5};
  return m;
}

TEST(Cdr, EveryCutIsNoticed) {
  const auto whole = to_cdr(trace());
  EXPECT_EQ(fault_of<GprTraceMessage>(whole), "");
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(fault_of<GprTraceMessage>({whole.begin(), whole.begin() + size}), "") << size;
}

TEST(Cdr, FillingIsAllowedAndMoreIsNot) {
  auto bytes = to_cdr(CommandMessage{"reset", ""});
  bytes.resize(bytes.size() + 3);
  EXPECT_EQ(fault_of<CommandMessage>(bytes), "");
  bytes.resize(bytes.size() + 1);
  EXPECT_EQ(fault_of<CommandMessage>(bytes), "has bytes left over");
}

TEST(Cdr, CountsAreNotBelieved) {
  auto bytes = to_cdr(trace());
  const std::size_t at = bytes.size() - 5 * 4 - 4;
  for (const std::uint32_t count : {6u, 0x7fffffffu, 0xffffffffu, 0x40000000u}) {
    std::memcpy(bytes.data() + at, &count, sizeof count);
    EXPECT_EQ(fault_of<GprTraceMessage>(bytes), "has a count beyond its end") << count;
  }
  // A sequence of texts and one of structures: as many as there are bytes for, and no more.
  std::vector<std::uint8_t> texts = to_cdr(Header());
  texts.resize(aligned(texts.size(), 4));
  texts.insert(texts.end(), {0xff, 0xff, 0xff, 0xff});
  EXPECT_EQ(fault_of<JointState>(texts), "is cut short");
  EXPECT_EQ(fault_of<TFMessage>({0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff}), "is cut short");
}

TEST(Cdr, TextsHaveAnEnd) {
  EXPECT_EQ(fault_of<KeyValue>({0, 1, 0, 0, 1, 0, 0, 0, 'x'}), "has a text without an end");
  EXPECT_EQ(fault_of<KeyValue>({0, 1, 0, 0, 0, 0, 0, 0}), "has a text without an end");
  EXPECT_EQ(fault_of<KeyValue>({0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 0}), "is cut short");
}

TEST(Cdr, OtherEncodingsAreRefusedAndBigEndianIsRead) {
  EXPECT_EQ(fault_of<Int64>({0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}), "is not in plain CDR");
  EXPECT_EQ(fault_of<Int64>({0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}), "is not in plain CDR");
  const std::vector<std::uint8_t> big = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2};
  EXPECT_EQ(from_cdr<Int64>(big.data(), big.size()).data, 258);
}

TEST(Cdr, ATruthValueIsOneOfTwo) {
  auto bytes = to_cdr(Revisit());
  bytes[bytes.size() - 16] = 2;
  EXPECT_EQ(fault_of<Revisit>(bytes), "has a truth value that is neither");
}

}  // namespace
}  // namespace gprodom::ros2
