#include "config/config_keys.h"

#include <map>
#include <utility>

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
Keys of_messages_and_motion(Config& c) {
  return {
    {"channels.prefix", &c.channels.prefix, "", Text{48, true}, "put before each name below that is left at its default"},
    {"channels.gpr_trace", &c.channels.gpr_trace, "", kChannel, "in: gpr_trace_t"},
    {"channels.imu", &c.channels.imu, "", kChannel, "in: imu_t"},
    {"channels.wheel", &c.channels.wheel, "", kChannel, "in: wheel_t"},
    {"channels.wheels", &c.channels.wheels, "", kChannel, "in: wheels_t, left and right; in place of wheel_t"},
    {"channels.displacement_in", &c.channels.displacement_in, "", kChannel, "in: displacement_t of another process"},
    {"channels.position_fix", &c.channels.position_fix, "", kChannel, "in: position_fix_t"},
    {"channels.command", &c.channels.command, "", kChannel, "in: command_t"},
    {"channels.displacement", &c.channels.displacement, "", kChannel, "out: displacement_t of the radar front end"},
    {"channels.odometry", &c.channels.odometry, "", kChannel, "out: odometry_t in odom, continuous"},
    {"channels.odometry_map", &c.channels.odometry_map, "", kChannel, "out: odometry_t in map, may jump"},
    {"channels.pose", &c.channels.pose, "", kChannel, "out: bot_core.pose_t in map, for viewers"},
    {"channels.correction", &c.channels.correction, "", kChannel, "out: correction_t, map to odom"},
    {"channels.status", &c.channels.status, "", kChannel, "out: status_t, once a second"},
    {"channels.sfm", &c.channels.sfm, "", kChannel, "out: sfm_t"},
    {"time.reorder_window", &c.time.reorder_window, "s", kReorderWindow, "messages older than the newest one by more than this are dropped"},
    {"imu.rpy_body_imu", &c.imu.rpy_body_imu, "rad", between(-6.3, 6.3), "roll, pitch, yaw of the IMU's axes in body; auto: found while driving"},
    {"imu.lever_arm", &c.imu.lever_arm, "m", between(-100, 100), "the accelerometer's place in body"},
    {"imu.gyro_noise_density", &c.imu.gyro_noise_density, "rad/s/sqrt(Hz)", kPositive, "lower limit; raised if a standstill shows more"},
    {"imu.accel_noise_density", &c.imu.accel_noise_density, "m/s^2/sqrt(Hz)", kPositive, "lower limit; raised if a standstill shows more"},
    {"imu.gyro_bias_walk", &c.imu.gyro_bias_walk, "rad/s^2/sqrt(Hz)", kPositive, "random walk of the gyro bias"},
    {"imu.accel_bias_walk", &c.imu.accel_bias_walk, "m/s^3/sqrt(Hz)", kPositive, "random walk of the accelerometer bias"},
    {"imu.max_acceleration", &c.imu.max_acceleration, "m/s^2", kPositive, "samples beyond are dropped"},
    {"imu.max_angular_velocity", &c.imu.max_angular_velocity, "rad/s", kPositive, "samples beyond are dropped"},
    {"imu.time_offset", &c.imu.time_offset, "s", between(-10, 10), "added to every stamp"},
    {"wheel.enabled", &c.wheel.enabled, "", kAny, "use the wheel encoder"},
    {"wheel.drive", &c.wheel.drive, "", kAny, "kind of drive; all but single learn turns from left and right wheels"},
    {"wheel.track", &c.wheel.track, "m", between(0.05, 10), "distance between left and right wheels, measured by tape; not used by single"},
    {"wheel.scale", &c.wheel.scale, "", between(0.1, 10), "reported distance over true distance"},
    {"wheel.scale_sigma", &c.wheel.scale_sigma, "", between(0, 1), "prior standard deviation of the scale; 0: fixed"},
    {"wheel.lever_arm", &c.wheel.lever_arm, "m", between(-100, 100), "the wheel's contact point in body"},
    {"wheel.noise", &c.wheel.noise, "m/sqrt(m)", kPositive, "random error, growing with distance"},
    {"wheel.noise_floor", &c.wheel.noise_floor, "m", kPositive, "error of one increment, from the encoder's resolution"},
    {"wheel.lateral_noise", &c.wheel.lateral_noise, "m/sqrt(m)", kPositive, "side slip, growing with distance"},
    {"wheel.vertical_noise", &c.wheel.vertical_noise, "m/sqrt(m)", kPositive, "motion off the ground plane, growing with distance"},
    {"wheel.robust_threshold", &c.wheel.robust_threshold, "standard deviations", kNotNegative, "increments beyond get less weight; 0: none"},
    {"wheel.slip_threshold", &c.wheel.slip_threshold, "standard deviations", kNotNegative, "difference of wheel and IMU that counts as slip; 0: no detection"},
    {"wheel.slip_share", &c.wheel.slip_share, "", between(0, 1), "share of the path on which the wheel slips gradually, without a jump; 0: never"},
    {"wheel.max_speed", &c.wheel.max_speed, "m/s", kNotNegative, "faster increments are dropped, until several agree; 0: learnt"},
    {"wheel.time_offset", &c.wheel.time_offset, "s", between(-10, 10), "added to every stamp"},
    {"standstill.enabled", &c.standstill.enabled, "", kAny, "detect standstill from IMU and wheel, and use it"},
    {"initializer.duration", &c.initializer.duration, "s", between(0.1, 600), "standstill needed to start"},
    {"initializer.wait_for_standstill", &c.initializer.wait_for_standstill, "", kAny, "start only from a standstill, never on the move"},
    {"smoother.state_rate", &c.smoother.state_rate, "Hz", between(0.5, 50), "states per second"},
    {"smoother.lag", &c.smoother.lag, "s", between(0.2, 1000), "length of the sliding window"},
    {"smoother.solver", &c.smoother.solver, "", kAny, "solver of the window: chain is our own; ceres takes the same steps at several times the cost"},
    {"smoother.latency", &c.smoother.latency, "s", between(0, 1), "data time from a state until its solution takes effect"},
  };
}

Keys of_radar_and_map(Config& c) {
  return {
    {"gpr.enabled", &c.gpr.enabled, "", kAny, "use the radar"},
    {"gpr.front_end", &c.gpr.front_end, "", kAny, "method that turns traces into displacements"},
    {"gpr.trigger", &c.gpr.trigger, "", kAny, "what makes a trace: a clock, or the way (a wheel, one each so many centimetres, none while the robot stands); auto: found from standstills"},
    {"gpr.tick", &c.gpr.tick, "s", between(0.01, 10), "data time between two answers of the front end"},
    {"gpr.latency_budget", &c.gpr.latency_budget, "s", between(0, 10), "data time from a tick until its answer takes effect"},
    {"gpr.wave_speed", &c.gpr.wave_speed, "m/s", between(1e7, 3e8), "of radar waves in the ground"},
    {"gpr.time_offset", &c.gpr.time_offset, "s", between(-10, 10), "added to every stamp"},
    {"gpr.time_offsets", &c.gpr.time_offsets, "s", between(-10, 10), "of each antenna by antenna_id, as {0: 0.004, 1: -0.001}; one that is not here has time_offset"},
    {"gpr.lever_arm", &c.gpr.lever_arm, "m", kAny, "antenna centre in body"},
    {"gpr.antennas", &c.gpr.antennas, "m", kAny, "antenna centres in body by antenna_id, as {0: [x, y, z], 1: [x, y, z]}, in place of lever_arm; {}: the antenna that is heard first"},
    {"gpr.filter.band_low", &c.gpr.filter.band_low, "Hz", kPositive, "lower edge of the band-pass"},
    {"gpr.filter.band_high", &c.gpr.filter.band_high, "Hz", kPositive, "upper edge of the band-pass"},
    {"gpr.filter.gain_rate", &c.gpr.filter.gain_rate, "1/sample", between(-1, 1), "rate of the exponential gain"},
    {"gpr.filter.gain_power", &c.gpr.filter.gain_power, "", between(-5, 5), "exponent of the sample number in the gain"},
    {"gpr.filter.gain_flat_after", &c.gpr.filter.gain_flat_after, "samples", between(0, 100000), "the gain is constant from this sample on"},
    {"gpr.coherence.use", &c.gpr.coherence.use, "", kAny, "when it enters the estimate: only if the wheel is contradicted or missing; always; never"},
    {"graph.enabled", &c.graph.enabled, "", kAny, "recognise ground seen before (loop closure), and correct map"},
    {"graph.latency", &c.graph.latency, "s", between(0, 60), "data time from a search until its result takes effect on map"},
    {"graph.patch_length", &c.graph.patch_length, "m", between(0.5, 3), "length of ground that is compared as a whole"},
    {"graph.lateral_sigma", &c.graph.lateral_sigma, "m", kPositive, "footprint of the antenna: ground so far aside has a correlation of 0.6"},
    {"anchor.enabled", &c.anchor.enabled, "", kAny, "positions from outside tie map to site"},
    {"anchor.antennas", &c.anchor.antennas, "m", kAny, "in body by the antenna_id of a fix, as {0: [x, y, z]}; of another id: at the origin of body"},
    {"anchor.datum", &c.anchor.datum, "deg, deg, m", kAny, "latitude, longitude and height of the origin of site, whose x is east; []: the first geodetic fix"},
    {"state.directory", &c.state.directory, "", Text{4096, true}, "folder where pose, wheel scale and ground are saved for the next run, of one estimator at a time; empty: not saved"},
    {"state.map", &c.state.map, "", kAny, "extend: new ground is added to ground.map; read_only: no ground is ever written"},
    {"state.save_period", &c.state.save_period, "s", kPositive, "data time between two savings of pose and wheel scale; what is new of the ground is saved 10 times less often, all of it 300 times"},
    {"state.resume_within", &c.state.resume_within, "s", kNotNegative, "resume from a saved pose if it is not older than this; 0: never"},
    {"logging.level", &c.logging.level, "", kAny, "what the daemon writes to its log"},
    {"logging.warning_period", &c.logging.warning_period, "s", kNotNegative, "time between two warnings of the same kind"},
    {"paper.window_traces", &c.gpr.sequential.window_traces, "", between(4, 2000), "L, traces in a window"},
    {"paper.rows", &c.gpr.sequential.rows, "", between(1, 500), "D_S, rows of the feature matrix"},
    {"paper.columns", &c.gpr.sequential.columns, "", between(4, 500), "L_S, columns of the feature matrix, in which shifts are counted"},
    {"paper.step", &c.gpr.sequential.step, "s", between(0.01, 60), "time between the compared windows (Delta t), a multiple of gpr.tick"},
    {"paper.k", &c.gpr.sequential.k, "m", between(0, 10), "K, displacement per column of shift; gprodom calibrate k fits it"},
    {"paper.sigma", &c.gpr.sequential.sigma, "m", between(0, 10), "standard deviation of K times the shift, over one step"},
    {"paper.distance", &c.gpr.sequential.distance, "", kAny, "cosine, or as the paper prints it (without the square root)"},
    {"paper.fit_peaks", &c.gpr.peaks.fit, "", kAny, "damped sinusoid per pulse; false: envelope maxima, much cheaper"},
    {"paper.publish_sfm", &c.gpr.sequential.publish_sfm, "", kAny, "publish each window's feature matrix beside the displacement"},
    {"paper.fusion", &c.gpr.fusion, "", kAny, "how a displacement enters the estimate: signed, or as the paper's norm"},
    {"paper.wheel_form", &c.wheel.form, "", kAny, "how the wheel enters the estimate: signed increment with the gyro, or the paper's distance norm"},
  };
}
// clang-format on

}  // namespace

std::vector<ConfigKey> config_keys(Config& config) {
  Keys keys = of_messages_and_motion(config);
  for (ConfigKey& key : of_radar_and_map(config)) keys.push_back(std::move(key));
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
