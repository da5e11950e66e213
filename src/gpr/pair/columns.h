// What one antenna has seen along the way: a column of spectra for each centimetre.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <vector>

#include "gpr/pair/travel.h"
#include "gprodom/types.h"

namespace gprodom::gpr {

// Columns, or equally spaced samples of them: a row for each place.
using ColumnMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class AntennaColumns {
 public:
  void add(TimeNs time, Eigen::VectorXf spectra);

  // Puts the traces since the last call into columns: those of one place are averaged. `travel`
  // reaches up to the newest of them.
  void collect(const Travel& travel);

  void forget_before(TimeNs time);
  void clear();

  // Where the newest column is, on a run. There must be one.
  double newest(const Run& run) const {
    return run.at((run.steady() ? recent_ : columns_).back().time);
  }
  bool empty() const { return columns_.empty(); }

  // The columns at s = begin, begin + spacing, ... (m) of a run; cubic between neighbours. Of a
  // steady run each trace of the last seconds is a column. false: the antenna has not seen all of
  // these places.
  bool sample(const Run& run, double begin, double spacing, Eigen::Index count,
              ColumnMatrix& rows) const;

 private:
  struct Column {
    TimeNs time = 0;  // mean of its traces
    Eigen::VectorXf spectra;
  };
  std::vector<Column> waiting_;
  std::deque<Column> recent_;  // the traces of the last seconds, whatever the path
  std::deque<Column> columns_;
  // Of the newest column, which may still grow: its first trace, and the number of its traces.
  TimeNs first_ = 0;
  int traces_ = 0;
};

}  // namespace gprodom::gpr
