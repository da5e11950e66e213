// How a sequential front end compares the last L traces from step to step: as an SFM, as the B-scan
// itself, as a dominant energy curve, as salient regions, or by counting traces only. There is one
// matcher for each method, with the same three functions. Shifts are in columns of the SFM grid
// (L_S per window), whatever the method's own resolution.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "gpr/sequential/alignment.h"
#include "gpr/sequential/sfm.h"
#include "gprodom/config.h"

namespace gprodom::gpr {

// The last `capacity` of a stream, with places reused: storing in place() does not allocate.
template <typename T>
class Ring {
 public:
  explicit Ring(std::size_t capacity) : items_(capacity) {}

  // The oldest place, to be overwritten as the newest.
  T& place() {
    T& item = items_[next_];
    next_ = (next_ + 1) % items_.size();
    if (size_ < items_.size()) ++size_;
    return item;
  }
  // 0 is the oldest; valid when full.
  const T& operator[](std::size_t i) const { return items_[(next_ + i) % items_.size()]; }
  bool full() const { return size_ == items_.size(); }
  std::size_t capacity() const { return items_.size(); }
  void clear() { next_ = size_ = 0; }

 private:
  std::vector<T> items_;
  std::size_t next_ = 0, size_ = 0;
};

// The last traces as the columns of a B-scan; in place of a bad one is a column of zeros.
class TraceColumns {
 public:
  explicit TraceColumns(int traces) : ring_(static_cast<std::size_t>(traces)) {}

  void add(const float* samples, std::size_t count);  // null: it is bad
  // Whether there are enough traces, and a good one among them.
  bool full() const { return ring_.full() && samples_ > 0; }
  void fill(Eigen::MatrixXf& bscan) const;
  bool good(std::size_t column) const { return ring_[column].size() == samples_; }
  void clear();

 private:
  Ring<std::vector<float>> ring_;  // empty where a trace was bad
  std::size_t samples_ = 0;        // of the newest good trace
};

// One trace, raw and filtered. Both are null if the trace was dead or spiked. Its place in the
// window then stays empty, so that the other traces keep their places.
struct WindowTrace {
  double time_s = 0.0;  // data time since the front end began
  const float* raw = nullptr;
  const float* filtered = nullptr;
  std::size_t count = 0;
  double sample_interval_s = 0.0;
  double time_zero_s = 0.0;
};

class WindowMatcher {
 public:
  virtual ~WindowMatcher() = default;

  virtual void add(const WindowTrace& trace) = 0;

  // Ends a step: compares the window that ends now with that of the last call, and returns the
  // shift of the older content in the newer window (negative, since traces enter on the right).
  // Empty until the window is full; not valid if there is no earlier window.
  virtual std::optional<Alignment> advance() = 0;

  // The matrix of the window at the last advance(), for methods that make one.
  virtual const LevelMatrix* levels() const { return nullptr; }

  virtual void reset() = 0;
};

// A method that makes a matrix of features in the window.
class FeatureMatcher : public WindowMatcher {
 public:
  const LevelMatrix* levels() const override { return levels_.size() > 0 ? &levels_ : nullptr; }
  void reset() override;

 protected:
  explicit FeatureMatcher(const SequentialConfig& config);

  // The matrix of points_ (positions in traces), aligned with that of the last call; not valid if
  // there was none. For the two scales see SfmGrid.
  Alignment match(double depth_range, double amplitude_scale);

  std::vector<FeaturePoint> points_;

 private:
  SfmGrid grid_;
  Aligner aligner_;
  LevelMatrix before_, levels_;
};

// One file each.
std::unique_ptr<WindowMatcher> make_sfm_matcher(const GprConfig& config);
std::unique_ptr<WindowMatcher> make_bscan_matcher(const GprConfig& config);
std::unique_ptr<WindowMatcher> make_dec_matcher(const GprConfig& config);
std::unique_ptr<WindowMatcher> make_salient_matcher(const GprConfig& config);

AlignmentOptions alignment_options(const SequentialConfig& config);

// Converts columns that are traces (L per window) to columns of the SFM grid.
double columns_per_trace(const SequentialConfig& config);
Alignment in_grid_columns(Alignment alignment, double columns_per_trace);

// Of kSfm, kBscan, kDec, kSalient or kTraceCount; throws std::invalid_argument on another front
// end.
std::unique_ptr<WindowMatcher> make_window_matcher(const GprConfig& config);

}  // namespace gprodom::gpr
