// Columns of one byte per row, in the order driven: the storage of a trace memory. The oldest are
// forgotten a block at a time.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "gpr/revisit/patch_filter.h"

namespace gprodom::gpr {

// One column per row of the matrix.
using Levels = Eigen::Matrix<std::int8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class ByteColumns {
 public:
  static constexpr std::size_t kBlock = 50;  // columns

  std::size_t size() const { return size_; }  // columns
  std::size_t bytes() const;

  // `values` are multiplied by levels_per_unit, rounded, and limited to a byte. All columns have
  // the same number of rows.
  void push(const Eigen::RowVectorXf& values, float levels_per_unit);
  void push(const std::int8_t* levels, std::size_t rows);
  void pop_newest(std::size_t count);
  void forget_block();  // the oldest; call only when it is full

  // `count` columns from number `first` on, counted from the oldest that is stored.
  Levels levels(std::size_t first, std::size_t count) const;
  Columns values(std::size_t first, std::size_t count, float levels_per_unit) const;

 private:
  template <typename Out, typename From>
  void copy(std::size_t first, std::size_t count, Out& out, From from) const;

  std::size_t rows_ = 0, size_ = 0;
  std::deque<std::vector<std::int8_t>> blocks_;  // all full but the newest
};

}  // namespace gprodom::gpr
