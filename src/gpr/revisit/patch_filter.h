// Turns raw traces along the track into the features that distinguish one place from another.
//
// What distinguishes a place changes along the track over decimetres. The direct wave and flat
// layers are the same everywhere, so they are removed. Noise and short wavelengths are removed too,
// because a lateral offset of the antenna decorrelates those. The rest is whitened over depth (each
// row gets equal variance) and over frequency, so that each independent sample has the same weight.
// Then the correlation coefficient is the statistic of the likelihood ratio, and no single strong
// reflector dominates it. See docs/revisit.md.
//
// All of this is linear in the trace and learnt once from the ground. So one small matrix makes a
// column of features of a trace, and a band-pass along the track follows.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace gprodom::gpr {

// One trace (or one column of features) per row, in the order driven.
using Columns = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Lengths are in wavelengths at the centre of the received spectrum, frequencies in units of it.
struct PatchFilterOptions {
  double wave_speed = 1e8;       // m/s in the ground
  double low_cut = 0.3;          // the whitened band, half gain
  double high_cut = 1.5;         // the same
  double spectrum_floor = 1e-4;  // of the spectrum's maximum; weaker frequencies are not amplified
  double long_cut = 1.1;         // standard deviation of the running mean along the track taken out
  double short_cut = 0.11;       // standard deviation of the smoothing along the track
  int max_rows = 96;             // features in a column: bytes in the trace memory
  double max_long_cut = 0.5;     // m: a patch must be several times longer
  double taken_out = 0.0;        // columns: long_sigma of the running mean already removed; 0: none
  int row_step = 0;              // samples from one feature to the next; 0: what the band needs
};

// A running mean along the track, three times over: close to a Gaussian of that standard
// deviation (in columns; below 0.5 nothing is done). Windows shrink at the ends.
void smooth_along(double sigma, Columns& columns);

// Standard deviation (samples) of the Gaussian mean that lets pass half of what is at `cut` cycles
// per sample.
double gaussian_of(double cut);

// Glitches of the receiver are traces unlike both neighbours and unlike their mean. Replaces each
// by the mean of its neighbours and returns how many there were.
int repair_columns(Columns& columns);

// The learnt parameters of a filter, to be stored beside the features that it made.
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
  Columns project(const Columns& traces) const;

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
  // Columns to either side that its smoothing reaches: three running means, half widths below
  // sigma + 1.
  Eigen::Index smoothing_reach() const {
    return 3 * static_cast<Eigen::Index>(std::ceil(learnt_.short_sigma + 1.0));
  }
  const LearntPatchFilter& learnt() const { return learnt_; }

 private:
  void learn_projection(const Columns& traces, double spacing, double sample_interval,
                        const PatchFilterOptions& options);
  void weigh_rows(const Columns& traces, bool without_mean);

  LearntPatchFilter learnt_;
};

}  // namespace gprodom::gpr
