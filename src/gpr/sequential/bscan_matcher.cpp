// B-scan against B-scan (front end bscan).
#include <algorithm>

#include "gpr/sequential/window_matcher.h"

namespace gprodom::gpr {

namespace {

// The raw B-scan less the window's mean trace. Otherwise the direct wave, which is equal in all
// traces, would make every shift a perfect match.
class BscanMatcher : public WindowMatcher {
 public:
  explicit BscanMatcher(const GprConfig& config)
      : columns_per_trace_(columns_per_trace(config.sequential)),
        traces_(config.sequential.window_traces),
        aligner_(alignment_options(config.sequential)) {}

  void add(const WindowTrace& trace) override { traces_.add(trace.raw, trace.count); }

  std::optional<Alignment> advance() override {
    if (!traces_.full()) return std::nullopt;
    fill_window();
    std::optional<Alignment> result;
    if (before_.size() == window_.size()) {
      result = in_grid_columns(aligner_.align(before_, window_), columns_per_trace_);
    }
    std::swap(before_, window_);
    return result;
  }

  void reset() override {
    traces_.clear();
    before_.resize(0, 0);
  }

 private:
  void fill_window() {
    traces_.fill(window_);
    int good = 0;
    for (Eigen::Index c = 0; c < window_.cols(); ++c) good += is_good(c) ? 1 : 0;
    mean_ = window_.rowwise().sum() / static_cast<float>(std::max(good, 1));
    for (Eigen::Index c = 0; c < window_.cols(); ++c)
      if (is_good(c)) window_.col(c) -= mean_;
  }

  bool is_good(Eigen::Index column) const { return traces_.good(static_cast<std::size_t>(column)); }

  double columns_per_trace_;
  TraceColumns traces_;
  Aligner aligner_;
  Eigen::MatrixXf before_, window_;
  Eigen::VectorXf mean_;
};

}  // namespace

std::unique_ptr<WindowMatcher> make_bscan_matcher(const GprConfig& config) {
  return std::make_unique<BscanMatcher>(config);
}

}  // namespace gprodom::gpr
