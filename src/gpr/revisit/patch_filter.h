// What turns raw traces along the track into the features by which a place is told from others.
//
// A place is told by what changes along the track over decimetres: the direct wave and flat layers
// are the same everywhere, so they are taken out; noise and what a lateral offset of the antenna
// decorrelates (the short wavelengths) are taken out too. What is left is made white, over depth
// (each row to equal variance) and over frequency, so that each independent sample has one vote:
// the correlation coefficient is then the likelihood ratio's statistic, and not that of the one
// strong reflector. See docs/revisit.md.
//
// All of it is linear in the trace and learnt once from the ground, so that a trace becomes a
// column of features by one small matrix, followed by a band-pass along the track.
#pragma once

#include <Eigen/Core>

namespace gprodom::gpr {

// One trace (or one column of features) per row, in the order driven.
using Columns = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Lengths are in wavelengths at the centre of the received spectrum, frequencies in units of it.
struct PatchFilterOptions {
  double wave_speed = 1e8;       // m/s in the ground
  double low_cut = 0.3;          // the whitened band, half gain
  double high_cut = 1.5;         // the same
  double spectrum_floor = 1e-4;  // of the spectrum's maximum: what lies below is not lifted
  double long_cut = 1.1;         // standard deviation of the running mean along the track taken out
  double short_cut = 0.11;       // standard deviation of the smoothing along the track
  int max_rows = 96;             // features in a column: bytes in the trace memory
  double max_long_cut = 0.5;     // m: a patch must be several times longer
};

// A running mean along the track, three times over: close to a Gaussian of that standard
// deviation (in columns; below 0.5 nothing is done). Windows shrink at the ends.
void smooth_along(double sigma, Columns& columns);

// Replaces traces unlike both neighbours, and unlike what lies between them, by their
// neighbours' mean: glitches of the receiver. Returns how many.
int repair_columns(Columns& columns);

// What a filter has learnt, to be kept beside the features that it made.
struct LearntPatchFilter {
  Columns projection;                          // (rows, samples): traces to features
  double row_interval = 0.0;                   // s
  double centre = 0.0;                         // Hz
  double long_sigma = 0.0, short_sigma = 0.0;  // columns
};

class PatchFilter {
 public:
  PatchFilter() = default;

  // Throws std::invalid_argument where there is no projection or a figure is not finite.
  explicit PatchFilter(LearntPatchFilter learnt);

  // Learns spectrum, depth gain and noise from traces (columns, samples) at `spacing` m, which
  // should cover several metres. Throws std::invalid_argument on fewer than 16 traces or samples,
  // on values that are not finite, and where nothing changes along the track.
  PatchFilter(const Columns& traces, double spacing, double sample_interval,
              const PatchFilterOptions& options = {});

  // Traces -> features (columns, rows()) before the band-pass along the track.
  Columns project(const Columns& traces) const { return traces * learnt_.projection.transpose(); }

  // The band-pass along the track, in place.
  void band_pass_along(Columns& features) const;

  // Both, with glitches repaired first.
  Columns apply(const Columns& traces) const;

  int rows() const { return static_cast<int>(learnt_.projection.rows()); }
  int samples() const { return static_cast<int>(learnt_.projection.cols()); }
  double row_interval() const { return learnt_.row_interval; }  // s
  double centre_frequency() const { return learnt_.centre; }    // Hz, of the received spectrum
  double long_sigma() const { return learnt_.long_sigma; }      // columns
  double short_sigma() const { return learnt_.short_sigma; }    // columns
  const LearntPatchFilter& learnt() const { return learnt_; }

 private:
  void learn_projection(const Columns& traces, double spacing, double sample_interval,
                        const PatchFilterOptions& options);
  void weigh_rows(const Columns& traces);

  LearntPatchFilter learnt_;
};

}  // namespace gprodom::gpr
