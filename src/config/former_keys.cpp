#include "config/former_keys.h"

namespace gprodom {

const std::vector<RemovedKey>& removed_keys() {
  static const std::vector<RemovedKey> keys = {
      {"time.max_jump", "5",
       "a driver or a network holds data back for less, and a clock that is set moves by more"},
      {"time.imu_gap", "0.12",
       "it follows from the IMU's rate: of a slow one two lost samples are no gap yet", "0.1"},
      {"imu.accel_bias_sigma", "0.03",
       "it is what a calibrated MEMS sensor may be off by before the start; the bias itself is "
       "learnt from then on"},
      {"imu.adaptive_noise", "true",
       "the noise is only ever raised, to what the samples show: without that the covariance would "
       "deny vibration"},
      {"wheel.scale_walk", "1e-06",
       "a tyre's scale changes by far less than wheel.scale_sigma in a day, and what changes "
       "within seconds is slip, which has a model of its own"},
      {"wheel.slip_window", "0.3",
       "it must hold the jump at the onset of a slip: over a longer window the error of the speed "
       "hides it, over a shorter one the encoder's steps do"},
      {"wheel.slip_size", "0.5",
       "it is the belief before anything is measured and covers ice, snow and gravel; how far a "
       "wheel slips is then measured by the IMU"},
      {"wheel.slip_lasts", "20",
       "it depends on the ground ahead, which nobody knows; the IMU shows within it how the slip "
       "changes"},
      {"standstill.window", "0.4",
       "it is two intervals between states: in a single one, a robot that glides evenly is still"},
      {"standstill.imu_ratio", "1.6",
       "it is a ratio to the noise of this robot at rest, which is learnt, and depends only on how "
       "a variance over one interval scatters"},
      {"standstill.velocity_sigma", "0.002",
       "a robot on its tyres sways by no more, and what its sensors show of that is in their "
       "learnt noise"},
      {"standstill.position_sigma", "1e-04",
       "it is how far a standing robot creeps from one state to the next, too little for a user to "
       "measure"},
      {"standstill.rotation_sigma", "1e-05",
       "it is how far a standing robot turns from one state to the next, far below what its gyro "
       "shows"},
      {"initializer.max_gyro_std", "0.02",
       "it is several times the noise of a MEMS gyro; where an engine shakes the robot more, a "
       "wheel that stands still decides"},
      {"initializer.max_accel_std", "0.2",
       "it is several times the noise of a MEMS accelerometer; where an engine shakes the robot "
       "more, a wheel that stands still decides"},
      {"initializer.max_gyro_mean", "0.05",
       "no gyro in use has a bias of 3 degrees/s, so a robot that shows more is turning"},
      {"initializer.position_sigma", "0.001",
       "the place of the start is the origin by definition; the solver only needs a weight that is "
       "finite"},
      {"initializer.yaw_sigma", "0.001",
       "the heading at the start is the x axis of odom by definition; the solver only needs a "
       "weight that is finite"},
      {"initializer.gravity", "9.80665",
       "it differs by 0.03 m/s^2 at most from place to place, which the accelerometer's bias takes "
       "up"},
      {"smoother.max_iterations", "4",
       "the solution has converged by then: with 50 the errors are the same (docs/lessons.md)"},
      {"gpr.max_gap", "1",
       "a robot may drive further in it than traces stay similar, so nothing can be compared "
       "across a longer gap"},
      {"gpr.stationary_window", "0.6",
       "at 20 traces/s it holds the fewest from which a trend can be told, and a longer window "
       "would tell a standstill later"},
      {"gpr.robust_threshold", "2.5",
       "it counts the standard deviations that the front end gives with each displacement, and so "
       "depends on no sensor"},
      {"gpr.filter.dewow_window", "8e-09",
       "the drift of a receiver's zero is slower than any echo; which echoes there are is said by "
       "the band"},
      {"gpr.filter.time_zero_max", "1e-09",
       "beyond half a period of the antenna, one half-wave would be taken for the next"},
      {"gpr.filter.background", "running",
       "the mean of a fixed window takes in the ground below a robot that stands; the running mean "
       "gives it little weight"},
      {"gpr.filter.background_memory", "400",
       "echoes average out over so many traces, and the antenna warms up more slowly"},
      {"gpr.filter.wavelet", "sym4",
       "the filters need only be short and nearly symmetric, so that echoes keep their place"},
      {"gpr.filter.wavelet_levels", "4",
       "what the last level leaves lies below a 32nd of the sampling rate, where an antenna that "
       "is sampled as usual has none of its band"},
      {"gpr.filter.wavelet_threshold", "1",
       "it is a multiple of the noise in each trace, which is measured"},
      {"gpr.filter.band_length", "1e-08",
       "it says how steep the edges of the band are, and the edges themselves are settings"},
      {"gpr.peaks.min_snr", "3.5",
       "it is a multiple of the noise in each trace, which is measured, not of a voltage"},
      {"gpr.peaks.min_relative", "0.05",
       "it is a share of the strongest echo in the same trace, whatever the antenna's gain"},
      {"gpr.peaks.max_joint", "1",
       "on ground, pulses that are fitted together repeat worse than those fitted one by one "
       "(docs/sfm.md)"},
      {"gpr.peaks.max_residual", "0.3",
       "it is the share of a pulse's energy that the model may leave; for an antenna whose pulses "
       "it does not describe there is paper.fit_peaks: false"},
      {"gpr.sequential.max_depth", "0",
       "the matrix reaches as deep as the traces do; with a depth in metres the displacement would "
       "depend on the wave speed"},
      {"gpr.sequential.min_overlap", "0.3",
       "a shorter overlap matches by chance on any ground (docs/sfm.md)"},
      {"gpr.sequential.scale_duration", "20",
       "the paper does not say when its amplitude scale is known; a shorter time only gives more "
       "displacements, with the errors of the methods compared with (docs/lessons.md)"},
      {"gpr.sequential.scale_quantile", "0.99",
       "the greatest amplitude would hang on one glitch; another quantile moves all levels alike"},
      {"gpr.dec.energy_window", "2e-09",
       "it is a period of the antenna that the method was compared on; the method only counts "
       "traces, whatever the value (docs/sfm.md)"},
      {"gpr.dec.first_time", "4e-09",
       "the direct wave is over by then, and before that it is stronger than any echo"},
      {"gpr.dec.jump_penalty", "0.01",
       "the method's own paper does not state it, and the method is here for comparison alone"},
      {"gpr.dec.smoothing", "7",
       "the method's own paper does not state it either; it is a fraction of a window"},
      {"gpr.coherence.span", "1",
       "the error of a distance is learnt for this span; a longer one would hide a slip, a shorter "
       "one has too few steps"},
      {"gpr.coherence.scale_distance", "5",
       "it depends on how fast the ground ahead changes, which nobody knows; the error that comes "
       "of it is learnt beside the scale"},
      {"gpr.coherence.min_sigma", "0.05",
       "it only bounds the learnt error from below, at less than the best ground measured has "
       "(docs/observability.md)"},
      {"graph.settle", "1",
       "after a longer wait more slip has shown, but the map is late, which costs more"},
      {"graph.node_spacing", "0.5",
       "it is a quarter of a patch of ground: closer nodes cost time, and say nothing of the track "
       "that a patch shows"},
      {"graph.query_spacing", "0.25",
       "closer searches compare mostly the same ground, and each counts only by what is new in it"},
      {"graph.gate_sigmas", "3",
       "it counts standard deviations of the position, which the estimator knows"},
      {"graph.gate_min", "0.6",
       "it is a third of a patch: so near, ground is searched even where the covariance is too "
       "small"},
      {"graph.gate_max", "5",
       "the time of a search and the places that match by chance grow with it, on every robot"},
      {"graph.lateral_gate", "0.4",
       "tracks that are 40 cm apart see ground too different to be matched (docs/revisit.md)"},
      {"graph.certainty", "0.999",
       "it is a probability: with it, none of 1870 queries was answered wrongly (docs/revisit.md)"},
      {"graph.sigma_factor", "1.3",
       "it was measured on real ground (docs/revisit.md), and takes a true position to measure "
       "again",
       "1.7"},
      {"graph.memory_length", "10000",
       "it bounds the memory, to some 50 MB; older ground is forgotten first"},
      {"graph.locate_every", "2",
       "a search of all ground takes tens of milliseconds on any robot, so it is not made with "
       "every patch"},
      {"state.map_save_period", "300",
       "it follows from state.save_period: the ground is saved every 300 times that"},
      {"graph.locate_length", "10",
       "a shorter query matches at too many places, and along a longer one the odometry errs by "
       "more than a match bears"},
  };
  return keys;
}

const std::vector<MovedKey>& moved_keys() {
  static const std::vector<MovedKey> keys = {
      {"wheel.form", "paper.wheel_form"},
      {"gpr.fusion", "paper.fusion"},
      {"gpr.peaks.fit", "paper.fit_peaks"},
      {"gpr.sequential.window_traces", "paper.window_traces"},
      {"gpr.sequential.rows", "paper.rows"},
      {"gpr.sequential.columns", "paper.columns"},
      {"gpr.sequential.step", "paper.step"},
      {"gpr.sequential.k", "paper.k"},
      {"gpr.sequential.sigma", "paper.sigma"},
      {"gpr.sequential.distance", "paper.distance"},
      {"gpr.sequential.publish_sfm", "paper.publish_sfm"},
  };
  return keys;
}

}  // namespace gprodom
