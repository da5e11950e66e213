#include "gpr/revisit/byte_columns.h"

#include <algorithm>
#include <cmath>

namespace gprodom::gpr {

std::size_t ByteColumns::bytes() const {
  std::size_t sum = blocks_.size() * sizeof(std::vector<std::int8_t>);
  for (const auto& block : blocks_) sum += block.capacity();
  return sum;
}

void ByteColumns::push(const Eigen::RowVectorXf& values, float levels_per_unit) {
  std::vector<std::int8_t> levels(static_cast<std::size_t>(values.size()));
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const float level = std::round(levels_per_unit * values[static_cast<Eigen::Index>(i)]);
    levels[i] = static_cast<std::int8_t>(std::clamp(level, -127.0F, 127.0F));
  }
  push(levels.data(), levels.size());
}

void ByteColumns::push(const std::int8_t* levels, std::size_t rows) {
  rows_ = rows;
  if (size_ % kBlock == 0) {
    blocks_.emplace_back();
    blocks_.back().reserve(kBlock * rows);
  }
  blocks_.back().insert(blocks_.back().end(), levels, levels + rows);
  ++size_;
}

void ByteColumns::pop_newest(std::size_t count) {
  for (; count > 0; --count, --size_) {
    auto& block = blocks_.back();
    block.resize(block.size() - rows_);
    if (block.empty()) blocks_.pop_back();
  }
}

void ByteColumns::forget_block() {
  blocks_.pop_front();
  size_ -= kBlock;
}

template <typename Out, typename From>
void ByteColumns::copy(std::size_t first, std::size_t count, Out& out, From from) const {
  out.resize(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(rows_));
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = first + i;
    const std::int8_t* bytes = blocks_[at / kBlock].data() + at % kBlock * rows_;
    for (std::size_t row = 0; row < rows_; ++row) out(i, row) = from(bytes[row]);
  }
}

Levels ByteColumns::levels(std::size_t first, std::size_t count) const {
  Levels levels;
  copy(first, count, levels, [](std::int8_t level) { return level; });
  return levels;
}

Columns ByteColumns::values(std::size_t first, std::size_t count, float levels_per_unit) const {
  Columns values;
  copy(first, count, values, [&](std::int8_t level) { return level / levels_per_unit; });
  return values;
}

}  // namespace gprodom::gpr
