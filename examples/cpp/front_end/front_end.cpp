// A radar front end of one's own, in the estimator in place of gpr.front_end: front_end LOG.lcmlog
//
// It compares the newest trace with older ones. Where they are alike the antenna stands; the less
// alike they are, the farther it has moved. The log is one of `gprodom convert` or lcm-logger.
// Printed is what the front end found and how far the robot drove. Exit code 1 where the front end
// was of no use.
#include <gprodom/lcm_io.h>
#include <gprodom/odometry.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <exception>
#include <lcm/lcm-cpp.hpp>
#include <memory>

namespace {

using gprodom::TimeNs;

constexpr char kSource[] = "similarity";         // in displacement_t.source
constexpr TimeNs kSpan = 300'000'000;            // ns between the traces that are compared
constexpr std::size_t kMostTraces = 200;         // that are kept
constexpr float kBackground = 0.02f;             // share of a trace in the mean of all before
constexpr double kStanding = 0.9995;             // correlation from which the antenna stands
constexpr double kAlike = 0.95, kUnlike = 0.35;  // correlations between which it tells a distance

class SimilarityFrontEnd : public gprodom::gpr::FrontEnd {
 public:
  // Every trace, in time order. What the latest have in common (the direct wave) hides the ground,
  // so it is taken out of what tells the distance.
  void add_trace(const gprodom::GprTrace& trace) override {
    if (mean_.empty()) mean_ = trace.samples;
    Trace kept{trace.time, trace.samples, trace.samples};
    for (std::size_t i = 0; i < mean_.size(); ++i) {
      kept.ground[i] -= mean_[i];
      mean_[i] += kBackground * kept.ground[i];
    }
    traces_.push_back(std::move(kept));
    if (traces_.size() > kMostTraces) traces_.pop_front();
  }

  // Called every gpr.tick of data time (0.1 s). What is returned counts gpr.latency_budget later.
  std::vector<gprodom::gpr::Finding> tick(TimeNs /*tick*/) override {
    if (traces_.empty()) return {};
    const Trace& now = traces_.back();
    const auto before = std::find_if(traces_.rbegin(), traces_.rend(), [&](const Trace& trace) {
      return now.time - trace.time >= kSpan;
    });
    if (before == traces_.rend()) return {};  // too early to say anything
    const double alike = correlation(before->samples, now.samples);
    if (alike > kStanding) return {standstill(before->time, now.time, alike)};
    return {path_length(before->time, now.time, correlation(before->ground, now.ground))};
  }

  // After a gap in the traces, or when their length changes: nothing before counts any more.
  void reset() override {
    mean_.clear();
    traces_.clear();
  }

 private:
  struct Trace {
    TimeNs time;
    std::vector<float> samples, ground;
  };

  // "It did not move", published as a displacement_t of KIND_MOTION with a distance of 0. A
  // Standstill has no `valid`: where it is not sure, none is made. It is a strong word, since with
  // a still IMU it sets the velocity to zero even though the wheel turns. So it must not be said of
  // a slow motion; a small measured displacement is something else (TrackDisplacement below).
  static gprodom::gpr::Standstill standstill(TimeNs from, TimeNs to, double alike) {
    gprodom::gpr::Standstill found;
    found.from = from;
    found.to = to;
    found.source = kSource;
    found.sigma_m = 0.005;  // motion that traces so alike may hide
    found.score = alike;    // whatever is worth publishing beside it
    return found;
  }

  // How far, whichever way, also of KIND_MOTION. The unit is the distance over which this ground's
  // traces become unlike; how many metres that are, the estimator learns from wheel and IMU, and
  // the standard deviation (displacement_t.sigma) with it. valid: whether the two traces tell a
  // distance at all. Beyond a length they are just unlike, however far apart they are.
  static gprodom::gpr::PathLength path_length(TimeNs from, TimeNs to, double alike) {
    gprodom::gpr::PathLength found;
    found.from = from;
    found.to = to;
    found.source = kSource;
    found.score = alike;
    found.valid = alike > kUnlike && alike < kAlike;
    if (found.valid) found.lengths = std::sqrt(-2 * std::log(alike));
    return found;
  }

  // A method that knows metres and direction, such as an array of antennas, would return a
  // gprodom::gpr::TrackDisplacement, published as KIND_SEQUENTIAL: distance_m forwards positive,
  // sigma_m the standard deviation of that very distance. It is weighed against wheel and IMU by
  // its sigma_m: ten times too small, and ten times too much trust.

  static double correlation(const std::vector<float>& a, const std::vector<float>& b) {
    double ab = 0, aa = 0, bb = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      ab += static_cast<double>(a[i]) * b[i];
      aa += static_cast<double>(a[i]) * a[i];
      bb += static_cast<double>(b[i]) * b[i];
    }
    return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0.0;
  }

  std::vector<float> mean_;
  std::deque<Trace> traces_;  // oldest first
};

struct Found {
  long standstills = 0, distances = 0, others = 0;

  void count(const gprodom::Displacement& displacement) {
    if (displacement.kind == gprodom::DisplacementKind::kRevisit) return;  // of the trace memory
    if (displacement.source != kSource) {
      ++others;
    } else if (displacement.valid) {
      ++(displacement.distance_m == 0 ? standstills : distances);
    }
  }
};

int run(const char* path) {
  lcm::LogFile log(path, "r");
  if (!log.good()) {
    std::fprintf(stderr, "%s: cannot be read\n", path);
    return 1;
  }
  const gprodom::Config config = gprodom::default_config();
  // A factory, since the estimator makes the front end anew when it is reset. Live takes one, too.
  gprodom::Odometry odometry(config, gprodom::Execution::kInline,
                             [] { return std::make_unique<SimilarityFrontEnd>(); });
  Found found;
  std::size_t poses = 0;
  double distance_m = 0;
  const auto take = [&](const gprodom::Outputs& out) {
    for (const auto& displacement : out.displacements) found.count(displacement);
    poses += out.odometry.size();
    if (!out.odometry.empty()) distance_m = out.odometry.back().distance_m;
    for (const auto& warning : out.warnings) std::fprintf(stderr, "%s\n", warning.c_str());
  };
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    const auto input = gprodom::decode_input(config.channels, event->channel, event->data,
                                             static_cast<std::size_t>(event->datalen));
    if (!input) continue;
    if (const auto* imu = std::get_if<gprodom::ImuSample>(&*input)) odometry.add(*imu);
    if (const auto* wheel = std::get_if<gprodom::WheelSample>(&*input)) odometry.add(*wheel);
    if (const auto* wheels = std::get_if<gprodom::WheelsSample>(&*input)) odometry.add(*wheels);
    if (const auto* trace = std::get_if<gprodom::GprTrace>(&*input)) odometry.add(*trace);
    take(odometry.step());
  }
  take(odometry.finish());
  std::printf("%zu poses, %.2f m driven; %ld standstills and %ld distances of %s, %ld of others\n",
              poses, distance_m, found.standstills, found.distances, kSource, found.others);
  return found.standstills > 0 && found.distances > 0 && found.others == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: front_end LOG.lcmlog\n");
    return 2;
  }
  try {
    return run(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
