// The search for the place in the memory antenna's columns that the query antenna sees now: an
// offset along the track, and a stretch where the predicted motion was wrong by a share.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "gpr/pair/columns.h"

namespace gprodom::gpr {

struct Alongside {
  double offset = 0.0, stretch = 0.0;  // columns; share
  double correlation = 0.0;            // mean over the blocks, by their weight
  double variance = 0.0;               // of the offset, columns^2, if all errors were noise
  double score = 0.0;                  // evidence at the best place less that at the second one
};

// query (n rows), memory (n + 2 reach rows): as Transfer::apply leaves them; query less its mean.
// Row i of the query is row i + reach + offset of the memory, without stretch. weights: of each
// frequency. Nothing if the best place is at the edge of the search.
std::optional<Alongside> find_alongside(const ColumnMatrix& query, const ColumnMatrix& memory,
                                        Eigen::Index reach, const Eigen::ArrayXf& weights,
                                        double spacing_m);

// The same by the coherence of each frequency along the track, which a factor between the antennas
// does not change: before the transfer is known. Whole columns, without a stretch or a variance.
std::optional<Alongside> find_by_coherence(const ColumnMatrix& query, const ColumnMatrix& memory,
                                           Eigen::Index reach);

// What speaks for a correlation: less of the variance is left.
double evidence(double correlation);

// The mean over the rows is subtracted from each.
void subtract_mean(ColumnMatrix& rows);

// The rows of the memory that belong to those of the query.
ColumnMatrix aligned_rows(const ColumnMatrix& memory, Eigen::Index count, Eigen::Index reach,
                          double offset, double stretch);

}  // namespace gprodom::gpr
