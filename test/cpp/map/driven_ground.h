// Ground maps of straight drives over synthetic ground.
#pragma once

#include <cmath>

#include "gpr/synthetic_ground.h"
#include "map/ground_map.h"
#include "map/ground_map_file.h"

namespace gprodom {

constexpr double kAntennaAhead = 0.1;  // m, in body

inline double stored_m(const gpr::TraceMemory& memory) {
  return static_cast<double>(memory.kept().size()) * memory.spacing();
}

// As if it had been written and read.
inline GroundMap reloaded(const GroundMap& ground) {
  return ground_map_from("a.map", to_bytes(ground, ground.places), gpr::TraceMemoryOptions());
}

// What an antenna sees from `begin` to `end` (m), at 0.3 m/s, from a time (s) on.
inline void drive_over(gpr::TraceMemory& memory, const gpr::SyntheticGround& there,
                       gpr::SyntheticRadar& radar, double begin, double end, double time) {
  const double step = begin < end ? 0.015 : -0.015;
  for (double x = begin; (end - x) * step > 0.0; x += step, time += 0.05) {
    const GprTrace trace = radar.measure(there, x, time);
    memory.add(trace.time, trace.samples, trace.sample_interval_s, std::copysign(x, step));
  }
}

// Drives from `begin` to `end` (m) over ground `seed`, as another session of the map. The poses lie
// along y = 1, x is the distance (its negative where the robot comes back).
// on: it goes on driving, so that the last ground is not stored yet.
inline void drive(GroundMap& ground, unsigned seed, double begin, double end, unsigned noise = 1,
                  double wave_speed = 1e8, bool on = false) {
  const gpr::SyntheticGround there(seed, 40.0, wave_speed);
  gpr::SyntheticRadar radar(noise, 60.0);
  ground.memory.begin_session();
  const std::size_t first = ground.memory.kept().end;
  ground.format = {gpr::SyntheticGround::kSamples, gpr::SyntheticGround::kSampleInterval};
  drive_over(ground.memory, there, radar, begin, end, 1e6 * noise);
  if (!on) ground.memory.end_run();
  ground.origins.resize(ground.memory.sessions().size(),
                        {{kAntennaAhead, 0.0, 0.2}, "test", "mole", {0.004, 0.002, 0.005}});
  // Driven ahead, x is that of the body. Turned about, the body lies on the other side.
  const bool back = end < begin;
  for (std::size_t column = first; column < ground.memory.kept().end; column += 25) {
    const double distance = ground.memory.column(column).distance_m;
    const double x = back ? 2 * kAntennaAhead - distance : distance;
    ground.places.push_back({column, distance, {{x, 1.0}, back ? M_PI : 0.0}, 0});
  }
}

}  // namespace gprodom
