// bench_yard HOURS --json FILE [--rest S] [--pieces N] [--seed N] [--smooth] [KEY=VALUE]...:
// a robot that drives the same 400 m of a yard again and again for HOURS of data (yard_robot.h),
// and rests before each round (2 m/s, 1600 s: two rounds an hour). In one process and on one
// thread, as fast as it goes. Data are made as they are needed and are the same for the same seed.
//
// --pieces: so many runs of equal length in place of one, each of which goes on from what the one
// before has left in state.directory (a folder of its own is made, and removed at the end). A row
// each, too. Pieces after the first are located in its map: their NEES is by what they are off
// beside what that map is off at the same metre of the route.
//
// --smooth: in the end, all poses of the last piece are solved at once, and what that cost is told.
//
// Tells for each day (86,400 s of data, or the part of it) what it cost: processor milliseconds for
// each second of data, without the making of the data; the same in yardsticks (soak_meter.h);
// resident memory at its end, above that before the first estimator; size of ground.map; and how
// good it was: mean NEES of position and heading in map each second of driving (2 and 1 where the
// covariance is right), and RMS error of the position. The last day's cost and memory are told over
// the second day's.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "gprodom/config.h"
#include "live/runner.h"
#include "soak_meter.h"
#include "yard_robot.h"

namespace {

using namespace gprodom;

constexpr double kDay = 86'400.0;  // s
constexpr double kSpeed = 2.0;     // m/s

struct Options {
  double hours = 0.0, rest = 1600.0;
  int pieces = 1;
  unsigned seed = 1;
  bool smooth = false;
  std::string json;
  std::vector<std::string> settings;
};

struct Day {
  double seconds = 0.0, cpu_s = 0.0, yardstick_s = 0.0;
  double resident_mb = 0.0, map_mb = 0.0;
  double nees_xy = 0.0, nees_yaw = 0.0, square_m2 = 0.0, square_in_map_m2 = 0.0;  // sums
  int compared = 0, rounds = 0, revisits = 0, restarts = 0;

  double cpu_ms() const { return 1e3 * cpu_s / seconds; }
  double in_yardsticks() const { return cpu_s / seconds / yardstick_s; }
};

// The solution over all poses of the last piece.
struct Smoothing {
  std::size_t states = 0;
  double cpu_s = 0.0;
};

// A folder for state.directory that goes with its owner.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "gprodom-yard-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder can be made in /tmp");
    path_ = name;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string path() const { return path_.string(); }
  double megabytes(const std::string& file) const {
    std::error_code none;
    const auto size = std::filesystem::file_size(path_ / file, none);
    return none ? 0.0 : 1e-6 * static_cast<double>(size);
  }

 private:
  std::filesystem::path path_;
};

class Yard {
 public:
  explicit Yard(const Options& options)
      : options_(options),
        robot_(options.seed, kSpeed, options.rest),
        config_(config()),
        before_(resident_bytes()) {}

  std::vector<Day> run() {
    const auto seconds = static_cast<std::int64_t>(3600 * options_.hours);
    for (int piece = 0; piece < options_.pieces; ++piece) {
      const std::int64_t end = seconds * (piece + 1) / options_.pieces;
      auto runner = timed([&] { return std::make_unique<Runner>(config_, Execution::kInline); });
      const bool smooths = options_.smooth && piece + 1 == options_.pieces;
      if (smooths) runner->record();
      for (; done_s_ < end; ++done_s_) {
        if (day().seconds >= kDay || (piece > piece_ && day().seconds > 0)) days_.emplace_back();
        piece_ = piece;
        second(*runner);
        if ((done_s_ + 1) % 3600 == 0 || done_s_ + 1 == end) tell();
      }
      timed([&] { return runner->finish(); });
      if (smooths) smooth(*runner);
      timed([&] {
        runner.reset();
        return 0;
      });
      day().map_mb = folder_.megabytes("ground.map");
    }
    return days_;
  }
  const Smoothing& smoothing() const { return smoothing_; }

 private:
  void smooth(Runner& runner) {
    const double begin = processor_s();
    smoothing_.states = runner.smoothed().size();
    smoothing_.cpu_s = processor_s() - begin;
    std::fprintf(stderr, "smoothed: %zu states in %.1f s\n", smoothing_.states, smoothing_.cpu_s);
  }

  Config config() const {
    std::vector<std::string> settings = options_.settings;
    settings.push_back("state.directory=" + folder_.path());
    return default_config(settings);
  }
  Day& day() { return days_.back(); }

  // What it returns; its processor time is the day's.
  template <class Work>
  std::invoke_result_t<Work> timed(Work work) {
    const double begin = processor_s();
    auto result = work();
    day().cpu_s += processor_s() - begin;
    return result;
  }

  void second(Runner& runner) {
    const int rounds = robot_.rounds();
    const std::vector<Input> inputs = robot_.next_second();
    day().rounds += robot_.rounds() - rounds;
    const Outputs last = timed([&] {
      Outputs newest;
      for (const Input& input : inputs) {
        Outputs out = runner.feed(input);
        if (!out.corrections.empty()) correction_ = out.corrections.back().revisits;
        if (out.restarted) ++day().restarts;
        if (!out.odometry_in_map.empty()) newest = std::move(out);
      }
      return newest;
    });
    day().seconds += 1.0;
    day().revisits = correction_;
    yardstick_.measure();
    if (robot_.moves() && !last.odometry_in_map.empty()) compare(last.odometry_in_map.back());
  }

  void compare(const OdometryEstimate& estimate) {
    if (estimate.time != robot_.time()) return;
    const PlanarPose truth = robot_.pose();
    const Eigen::Vector3d ahead = estimate.q_odom_body * Eigen::Vector3d::UnitX();
    Off off{estimate.p_odom_body.head<2>() - truth.p,
            wrapped(std::atan2(ahead.y(), ahead.x()) - truth.yaw)};
    const double square = off.p.squaredNorm();
    std::optional<Off>& of_map = map_off_[static_cast<std::size_t>(robot_.along())];
    if (piece_ == 0) {
      of_map = off;
    } else if (of_map) {
      off = {off.p - of_map->p, wrapped(off.yaw - of_map->yaw)};
    } else {
      return;
    }
    const Eigen::Matrix2d covariance = estimate.pose_covariance.topLeftCorner<2, 2>();
    day().nees_xy += off.p.dot(covariance.inverse() * off.p);
    day().nees_yaw += off.yaw * off.yaw / estimate.pose_covariance(5, 5);
    day().square_m2 += square;
    if (piece_ > 0) day().square_in_map_m2 += off.p.squaredNorm();
    ++day().compared;
  }

  void tell() {
    const std::int64_t before = yardsticks_;
    yardsticks_ = static_cast<std::int64_t>(day().seconds);
    if (yardsticks_ <= before) yardstick_sum_s_ = 0.0;  // a new day
    yardstick_sum_s_ += yardstick_.take_mean_s();
    day().yardstick_s = yardstick_sum_s_ / std::ceil(day().seconds / 3600);
    day().resident_mb = 1e-6 * static_cast<double>(resident_bytes() - before_);
    day().map_mb = folder_.megabytes("ground.map");
    std::fprintf(stderr,
                 "%.0f h: %.2f ms, %.2f yardsticks a second; %.2f MB, map %.2f MB; %d revisits; "
                 "NEES %.2f, %.2f; %.3f m, in the map %.3f m\n",
                 static_cast<double>(done_s_ + 1) / 3600, day().cpu_ms(), day().in_yardsticks(),
                 day().resident_mb, day().map_mb, day().revisits, day().nees_xy / day().compared,
                 day().nees_yaw / day().compared, std::sqrt(day().square_m2 / day().compared),
                 std::sqrt(day().square_in_map_m2 / day().compared));
  }

  struct Off {  // in position, m, and heading
    Eigen::Vector2d p;
    double yaw;
  };
  const Options options_;
  YardRobot robot_;
  Folder folder_;
  const Config config_;
  const std::int64_t before_;
  std::vector<Day> days_ = {{}};
  Smoothing smoothing_;
  Yardstick yardstick_;
  std::int64_t done_s_ = 0, yardsticks_ = 0;
  double yardstick_sum_s_ = 0.0;
  int correction_ = 0, piece_ = 0;
  // Of the map of the first piece, at each metre of the route.
  std::vector<std::optional<Off>> map_off_{static_cast<std::size_t>(YardRoute::kLength) + 1};
};

void write_json(const Options& options, const std::vector<Day>& days, const Smoothing& smoothing,
                std::ostream& out) {
  out << "{\"hours\": " << options.hours << ", \"pieces\": " << options.pieces
      << ", \"seed\": " << options.seed << ", \"rest\": " << options.rest << ", \"days\": [";
  for (std::size_t i = 0; i < days.size(); ++i) {
    const Day& day = days[i];
    const double compared = std::max(1, day.compared);
    out << (i > 0 ? ",\n" : "\n") << "  {\"day\": " << i + 1 << ", \"seconds\": " << day.seconds
        << ", \"rounds\": " << day.rounds << ", \"cpu_ms_per_s\": " << day.cpu_ms()
        << ", \"yardsticks_per_s\": " << day.in_yardsticks()
        << ", \"resident_mb\": " << day.resident_mb << ", \"map_mb\": " << day.map_mb
        << ", \"nees_xy\": " << day.nees_xy / compared
        << ", \"nees_yaw\": " << day.nees_yaw / compared
        << ", \"rmse_m\": " << std::sqrt(day.square_m2 / compared)
        << ", \"rmse_in_map_m\": " << std::sqrt(day.square_in_map_m2 / compared)
        << ", \"revisits\": " << day.revisits << ", \"restarts\": " << day.restarts << '}';
  }
  out << "\n]";
  if (days.size() >= 2) {
    const Day &second = days[1], &last = days.back();
    out << ", \"cost_last_over_second\": " << last.in_yardsticks() / second.in_yardsticks()
        << ", \"memory_last_over_second\": " << last.resident_mb / second.resident_mb
        << ", \"map_last_over_second\": " << last.map_mb / second.map_mb;
  }
  if (options.smooth) {
    const auto states = static_cast<double>(smoothing.states);
    out << ", \"smoothed_states\": " << smoothing.states
        << ", \"smoothed_cpu_s\": " << smoothing.cpu_s
        << ", \"smoothed_us_per_state\": " << 1e6 * smoothing.cpu_s / std::max(1.0, states);
  }
  out << "}\n";
}

Options options_of(const std::vector<std::string>& arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (argument == "--smooth") {
      options.smooth = true;
      continue;
    }
    if (argument.rfind("--", 0) == 0 && i + 1 == arguments.size())
      throw std::invalid_argument(argument);
    if (argument == "--rest") {
      options.rest = std::stod(arguments[++i]);
    } else if (argument == "--pieces") {
      options.pieces = std::stoi(arguments[++i]);
    } else if (argument == "--seed") {
      options.seed = static_cast<unsigned>(std::stoul(arguments[++i]));
    } else if (argument == "--json") {
      options.json = arguments[++i];
    } else if (argument.find('=') != std::string::npos) {
      options.settings.push_back(argument);
    } else {
      options.hours = std::stod(argument);
    }
  }
  if (!(options.hours > 0 && options.hours <= 1000 && options.pieces > 0 && options.rest >= 5) ||
      options.json.empty())
    throw std::invalid_argument("HOURS");
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  try {
    options = options_of({argv + 1, argv + argc});
  } catch (const std::logic_error&) {
    std::cerr
        << "usage: bench_yard HOURS --json FILE [--rest S] [--pieces N] [--seed N] [--smooth] "
           "[KEY=VALUE]...\n"
           "HOURS of data up to 1000 on the same 400 m; what it tells: bench/yard.cpp\n";
    return 2;
  }
  try {
    Yard yard(options);
    const std::vector<Day> days = yard.run();
    std::ofstream file(options.json);
    write_json(options, days, yard.smoothing(), file);
    if (!file.flush()) throw std::runtime_error(options.json + ": cannot be written");
  } catch (const std::exception& error) {
    std::cerr << "bench_yard: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
