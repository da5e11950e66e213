#include "config/config_keys.h"

#include <map>

namespace gprodom {
namespace {

using Keys = std::vector<ConfigKey>;

const Range kAny{};
const Range kPositive{0.0, std::numeric_limits<double>::infinity(), true, ""};
const Range kNotNegative{0.0, std::numeric_limits<double>::infinity(), false, ""};
const Text kChannel{63};  // LCM allows no longer names

Range between(double minimum, double maximum, const char* why = "") {
  return {minimum, maximum, false, why};
}

// Error on a sample drive: 0.07 m with 0.35 s, 0.12 m with 3 s, 0.84 m with 10 s.
const Range kReorderWindow = between(
    0, 1, "every state waits for this time, and poses are predicted over it by the IMU alone");

// clang-format off
void add_channels(Keys& keys, ChannelConfig& c) {
  keys.insert(keys.end(), {
    {"channels.prefix", &c.prefix, "", Text{48, true}, "put before each name below that is left at its default"},
    {"channels.gpr_trace", &c.gpr_trace, "", kChannel, "in: gpr_trace_t"},
    {"channels.imu", &c.imu, "", kChannel, "in: imu_t"},
    {"channels.wheel", &c.wheel, "", kChannel, "in: wheel_t"},
    {"channels.wheels", &c.wheels, "", kChannel, "in: wheels_t, left and right; in place of wheel_t"},
    {"channels.displacement_in", &c.displacement_in, "", kChannel, "in: displacement_t of another process"},
    {"channels.position_fix", &c.position_fix, "", kChannel, "in: position_fix_t"},
    {"channels.command", &c.command, "", kChannel, "in: command_t"},
    {"channels.displacement", &c.displacement, "", kChannel, "out: displacement_t of the radar front end"},
    {"channels.odometry", &c.odometry, "", kChannel, "out: odometry_t in odom, continuous"},
    {"channels.odometry_map", &c.odometry_map, "", kChannel, "out: odometry_t in map, may jump"},
    {"channels.pose", &c.pose, "", kChannel, "out: bot_core.pose_t in map, for viewers"},
    {"channels.correction", &c.correction, "", kChannel, "out: correction_t, map to odom"},
    {"channels.status", &c.status, "", kChannel, "out: status_t, once a second"},
    {"channels.sfm", &c.sfm, "", kChannel, "out: sfm_t"},
  });
}

void add_time(Keys& keys, TimeConfig& c) {
  keys.insert(keys.end(), {
    {"time.reorder_window", &c.reorder_window, "s", kReorderWindow, "messages older than the newest one by more than this are dropped"},
  });
}

void add_imu(Keys& keys, ImuConfig& c) {
  keys.insert(keys.end(), {
    {"imu.rpy_body_imu", &c.rpy_body_imu, "rad", between(-6.3, 6.3), "roll, pitch, yaw of the IMU's axes in body; auto: found while driving"},
    {"imu.lever_arm", &c.lever_arm, "m", between(-100, 100), "the accelerometer's place in body"},
    {"imu.gyro_noise_density", &c.gyro_noise_density, "rad/s/sqrt(Hz)", kPositive, "lower limit; raised if a standstill shows more"},
    {"imu.accel_noise_density", &c.accel_noise_density, "m/s^2/sqrt(Hz)", kPositive, "lower limit; raised if a standstill shows more"},
    {"imu.gyro_bias_walk", &c.gyro_bias_walk, "rad/s^2/sqrt(Hz)", kPositive, "random walk of the gyro bias"},
    {"imu.accel_bias_walk", &c.accel_bias_walk, "m/s^3/sqrt(Hz)", kPositive, "random walk of the accelerometer bias"},
    {"imu.max_acceleration", &c.max_acceleration, "m/s^2", kPositive, "samples beyond are dropped"},
    {"imu.max_angular_velocity", &c.max_angular_velocity, "rad/s", kPositive, "samples beyond are dropped"},
    {"imu.time_offset", &c.time_offset, "s", between(-10, 10), "added to every stamp"},
  });
}

void add_wheel(Keys& keys, WheelConfig& c) {
  keys.insert(keys.end(), {
    {"wheel.enabled", &c.enabled, "", kAny, "use the wheel encoder"},
    {"wheel.drive", &c.drive, "", kAny, "kind of drive; all but single learn turns from left and right wheels"},
    {"wheel.track", &c.track, "m", between(0.05, 10), "distance between left and right wheels, measured by tape; not used by single"},
    {"wheel.scale", &c.scale, "", between(0.1, 10), "reported distance over true distance"},
    {"wheel.scale_sigma", &c.scale_sigma, "", between(0, 1), "prior standard deviation of the scale; 0: fixed"},
    {"wheel.lever_arm", &c.lever_arm, "m", between(-100, 100), "the wheel's contact point in body"},
    {"wheel.noise", &c.noise, "m/sqrt(m)", kPositive, "random error, growing with distance"},
    {"wheel.noise_floor", &c.noise_floor, "m", kPositive, "error of one increment, from the encoder's resolution"},
    {"wheel.lateral_noise", &c.lateral_noise, "m/sqrt(m)", kPositive, "side slip, growing with distance"},
    {"wheel.vertical_noise", &c.vertical_noise, "m/sqrt(m)", kPositive, "motion off the ground plane, growing with distance"},
    {"wheel.robust_threshold", &c.robust_threshold, "standard deviations", kNotNegative, "increments beyond get less weight; 0: none"},
    {"wheel.slip_threshold", &c.slip_threshold, "standard deviations", kNotNegative, "difference of wheel and IMU that counts as slip; 0: no detection"},
    {"wheel.slip_share", &c.slip_share, "", between(0, 1), "share of the path on which the wheel slips gradually, without a jump; 0: never"},
    {"wheel.max_speed", &c.max_speed, "m/s", kNotNegative, "faster increments are dropped, until several agree; 0: learnt"},
    {"wheel.time_offset", &c.time_offset, "s", between(-10, 10), "added to every stamp"},
  });
}

void add_standstill(Keys& keys, StandstillConfig& c) {
  keys.insert(keys.end(), {
    {"standstill.enabled", &c.enabled, "", kAny, "detect standstill from IMU and wheel, and use it"},
  });
}

void add_initializer(Keys& keys, InitializerConfig& c) {
  keys.insert(keys.end(), {
    {"initializer.duration", &c.duration, "s", between(0.1, 600), "standstill needed to start"},
    {"initializer.wait_for_standstill", &c.wait_for_standstill, "", kAny, "start only from a standstill, never on the move"},
  });
}

void add_smoother(Keys& keys, SmootherConfig& c) {
  keys.insert(keys.end(), {
    {"smoother.state_rate", &c.state_rate, "Hz", between(0.5, 50), "states per second"},
    {"smoother.lag", &c.lag, "s", between(0.2, 1000), "length of the sliding window"},
    {"smoother.solver", &c.solver, "", kAny, "solver of the window: chain is our own; ceres takes the same steps at several times the cost"},
    {"smoother.latency", &c.latency, "s", between(0, 1), "data time from a state until its solution takes effect"},
  });
}

void add_gpr(Keys& keys, GprConfig& c) {
  keys.insert(keys.end(), {
    {"gpr.enabled", &c.enabled, "", kAny, "use the radar"},
    {"gpr.front_end", &c.front_end, "", kAny, "method that turns traces into displacements"},
    {"gpr.trigger", &c.trigger, "", kAny, "what makes a trace: a clock, or the way (a wheel, one each so many centimetres, none while the robot stands); auto: found from standstills"},
    {"gpr.tick", &c.tick, "s", between(0.01, 10), "data time between two answers of the front end"},
    {"gpr.latency_budget", &c.latency_budget, "s", between(0, 10), "data time from a tick until its answer takes effect"},
    {"gpr.wave_speed", &c.wave_speed, "m/s", between(1e7, 3e8), "of radar waves in the ground"},
    {"gpr.time_offset", &c.time_offset, "s", between(-10, 10), "added to every stamp"},
    {"gpr.time_offsets", &c.time_offsets, "s", between(-10, 10), "of each antenna by antenna_id, as {0: 0.004, 1: -0.001}; one that is not here has time_offset"},
    {"gpr.lever_arm", &c.lever_arm, "m", kAny, "antenna centre in body"},
    {"gpr.antennas", &c.antennas, "m", kAny, "antenna centres in body by antenna_id, as {0: [x, y, z], 1: [x, y, z]}, in place of lever_arm; {}: the antenna that is heard first"},
  });
}

void add_gpr_filter(Keys& keys, GprFilterConfig& c) {
  keys.insert(keys.end(), {
    {"gpr.filter.band_low", &c.band_low, "Hz", kPositive, "lower edge of the band-pass"},
    {"gpr.filter.band_high", &c.band_high, "Hz", kPositive, "upper edge of the band-pass"},
    {"gpr.filter.gain_rate", &c.gain_rate, "1/sample", between(-1, 1), "rate of the exponential gain"},
    {"gpr.filter.gain_power", &c.gain_power, "", between(-5, 5), "exponent of the sample number in the gain"},
    {"gpr.filter.gain_flat_after", &c.gain_flat_after, "samples", between(0, 100000), "the gain is constant from this sample on"},
  });
}

void add_coherence(Keys& keys, CoherenceConfig& c) {
  keys.insert(keys.end(), {
    {"gpr.coherence.use", &c.use, "", kAny, "when it enters the estimate: only if the wheel is contradicted or missing; always; never"},
  });
}

// For the methods that compare one window of traces with the next.
void add_paper(Keys& keys, Config& config) {
  SequentialConfig& c = config.gpr.sequential;
  keys.insert(keys.end(), {
    {"paper.window_traces", &c.window_traces, "", between(4, 2000), "L, traces in a window"},
    {"paper.rows", &c.rows, "", between(1, 500), "D_S, rows of the feature matrix"},
    {"paper.columns", &c.columns, "", between(4, 500), "L_S, columns of the feature matrix, in which shifts are counted"},
    {"paper.step", &c.step, "s", between(0.01, 60), "time between the compared windows (Delta t), a multiple of gpr.tick"},
    {"paper.k", &c.k, "m", between(0, 10), "K, displacement per column of shift; gprodom calibrate k fits it"},
    {"paper.sigma", &c.sigma, "m", between(0, 10), "standard deviation of K times the shift, over one step"},
    {"paper.distance", &c.distance, "", kAny, "cosine, or as the paper prints it (without the square root)"},
    {"paper.fit_peaks", &config.gpr.peaks.fit, "", kAny, "damped sinusoid per pulse; false: envelope maxima, much cheaper"},
    {"paper.publish_sfm", &c.publish_sfm, "", kAny, "publish each window's feature matrix beside the displacement"},
    {"paper.fusion", &config.gpr.fusion, "", kAny, "how a displacement enters the estimate: signed, or as the paper's norm"},
    {"paper.wheel_form", &config.wheel.form, "", kAny, "how the wheel enters the estimate: signed increment with the gyro, or the paper's distance norm"},
  });
}

void add_graph(Keys& keys, GraphConfig& c) {
  keys.insert(keys.end(), {
    {"graph.enabled", &c.enabled, "", kAny, "recognise ground seen before (loop closure), and correct map"},
    {"graph.latency", &c.latency, "s", between(0, 60), "data time from a search until its result takes effect on map"},
    {"graph.patch_length", &c.patch_length, "m", between(0.5, 3), "length of ground that is compared as a whole"},
    {"graph.lateral_sigma", &c.lateral_sigma, "m", kPositive, "footprint of the antenna: ground so far aside has a correlation of 0.6"},
  });
}

void add_anchor(Keys& keys, AnchorConfig& c) {
  keys.insert(keys.end(), {
    {"anchor.enabled", &c.enabled, "", kAny, "positions from outside tie map to site"},
    {"anchor.antennas", &c.antennas, "m", kAny, "in body by the antenna_id of a fix, as {0: [x, y, z]}; of another id: at the origin of body"},
    {"anchor.datum", &c.datum, "deg, deg, m", kAny, "latitude, longitude and height of the origin of site, whose x is east; []: the first geodetic fix"},
  });
}

void add_state(Keys& keys, StateConfig& c) {
  keys.insert(keys.end(), {
    {"state.directory", &c.directory, "", Text{4096, true}, "folder where pose, wheel scale and ground are saved for the next run, of one estimator at a time; empty: not saved"},
    {"state.map", &c.map, "", kAny, "extend: new ground is added to ground.map; read_only: no ground is ever written"},
    {"state.save_period", &c.save_period, "s", kPositive, "data time between two savings of pose and wheel scale; what is new of the ground is saved 10 times less often, all of it 300 times"},
    {"state.resume_within", &c.resume_within, "s", kNotNegative, "resume from a saved pose if it is not older than this; 0: never"},
  });
}

void add_logging(Keys& keys, LoggingConfig& c) {
  keys.insert(keys.end(), {
    {"logging.level", &c.level, "", kAny, "what the daemon writes to its log"},
    {"logging.warning_period", &c.warning_period, "s", kNotNegative, "time between two warnings of the same kind"},
  });
}
// clang-format on

}  // namespace

std::vector<ConfigKey> config_keys(Config& config) {
  Keys keys;
  add_channels(keys, config.channels);
  add_time(keys, config.time);
  add_imu(keys, config.imu);
  add_wheel(keys, config.wheel);
  add_standstill(keys, config.standstill);
  add_initializer(keys, config.initializer);
  add_smoother(keys, config.smoother);
  add_gpr(keys, config.gpr);
  add_gpr_filter(keys, config.gpr.filter);
  add_coherence(keys, config.gpr.coherence);
  add_graph(keys, config.graph);
  add_anchor(keys, config.anchor);
  add_state(keys, config.state);
  add_logging(keys, config.logging);
  add_paper(keys, config);
  return keys;
}

std::string section_description(const std::string& section) {
  static const std::map<std::string, std::string> descriptions = {
      {"channels", "Names of the LCM channels."},
      {"time", "Time stamps of incoming messages."},
      {"imu", "Mounting and noise of the IMU."},
      {"wheel", "Scale, mounting and noise of the wheel encoder."},
      {"standstill", "Zero-velocity updates."},
      {"initializer", "Start of the estimator."},
      {"smoother", "The fixed-lag smoother."},
      {"gpr", "The ground-penetrating radar and its front end."},
      {"gpr.filter", "Filter of each trace: the antenna's band, and the gain."},
      {"gpr.coherence", "Distance from the decay of trace similarity (front end motion)."},
      {"graph", "Loop closure: trace memory, revisits, and the track in map."},
      {"anchor",
       "Positions from outside: GNSS, total station, surveyed markers. They tie map to site."},
      {"state", "What is saved for the next run."},
      {"logging", "The daemon's log."},
      {"paper",
       "The paper's method, and the methods it is compared with: front ends sfm, bscan, dec, "
       "salient and trace_count."},
  };
  const auto found = descriptions.find(section);
  return found == descriptions.end() ? std::string() : found->second;
}

}  // namespace gprodom
