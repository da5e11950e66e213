// B-scan against B-scan (front end bscan).
#include "gpr/sequential/window_matcher.h"

namespace gprodom::gpr {

namespace {

// The raw B-scan less the window's mean trace. Otherwise the direct wave, which is equal in all
// traces, would make every shift a perfect match.
class BscanMatcher : public WindowMatcher {
 public:
  explicit BscanMatcher(const GprConfig& config)
      : columns_per_trace_(columns_per_trace(config.sequential)),
        ring_(static_cast<std::size_t>(config.sequential.window_traces)),
        aligner_(alignment_options(config.sequential)) {}

  void add(const WindowTrace& trace) override {
    std::vector<float>& place = ring_.place();
    if (trace.raw == nullptr) {
      place.clear();
      return;
    }
    place.assign(trace.raw, trace.raw + trace.count);
    samples_ = trace.count;
  }

  std::optional<Alignment> advance() override {
    if (!ring_.full() || samples_ == 0) return std::nullopt;
    fill_window();
    std::optional<Alignment> result;
    if (before_.size() == window_.size()) {
      result = in_grid_columns(aligner_.align(before_, window_), columns_per_trace_);
    }
    std::swap(before_, window_);
    return result;
  }

  void reset() override {
    ring_.clear();
    before_.resize(0, 0);
    samples_ = 0;
  }

 private:
  void fill_window() {
    const auto samples = static_cast<Eigen::Index>(samples_);
    window_.setZero(samples, static_cast<Eigen::Index>(ring_.capacity()));
    mean_.setZero(samples);
    int used = 0;
    for (std::size_t c = 0; c < ring_.capacity(); ++c) {
      if (ring_[c].size() != samples_) continue;
      window_.col(static_cast<Eigen::Index>(c)) =
          Eigen::Map<const Eigen::VectorXf>(ring_[c].data(), samples);
      mean_ += window_.col(static_cast<Eigen::Index>(c));
      ++used;
    }
    if (used == 0) return;
    mean_ /= static_cast<float>(used);
    for (std::size_t c = 0; c < ring_.capacity(); ++c) {
      if (ring_[c].size() == samples_) window_.col(static_cast<Eigen::Index>(c)) -= mean_;
    }
  }

  double columns_per_trace_;
  Ring<std::vector<float>> ring_;  // empty where a trace was bad
  Aligner aligner_;
  Eigen::MatrixXf before_, window_;
  Eigen::VectorXf mean_;
  std::size_t samples_ = 0;
};

}  // namespace

std::unique_ptr<WindowMatcher> make_bscan_matcher(const GprConfig& config) {
  return std::make_unique<BscanMatcher>(config);
}

}  // namespace gprodom::gpr
