// Sound ground, for the corpus and as the file that newest ground belongs to.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "map/ground_map_file.h"

// Drives on over noise on short traces, from column to column (2 cm each). A few metres are small,
// and a filter can be learnt of them.
inline void drive_on(gprodom::GroundMap& ground, int from, int to) {
  std::mt19937 random(static_cast<unsigned>(from) + 1);
  std::normal_distribution<float> normal;
  for (int i = from; i < to; ++i) {
    std::vector<float> samples(ground.format.samples);
    for (float& sample : samples) sample = normal(random);
    ground.memory.add(gprodom::TimeNs{i}, samples, ground.format.sample_interval_s, 0.02 * i);
  }
}

inline gprodom::GroundMap sound_ground() {
  gprodom::GroundMap ground{gprodom::gpr::TraceMemoryOptions()};
  ground.format.samples = 40;
  ground.format.sample_interval_s = 4e-10;
  drive_on(ground, 0, 250);
  ground.memory.end_run();
  ground.origins = {{Eigen::Vector3d::Zero(), "corpus", "mole", {0.004, 0.002, 0.005}}};
  ground.parents = {1};
  ground.places = {{0, 0.0, {}, 0}, {5, 0.1, {}, 0}};
  return ground;
}

// The same where fixes have tied it to a site.
inline gprodom::GroundMap tied_ground() {
  gprodom::GroundMap ground = sound_ground();
  gprodom::MapDatum& datum = ground.datums[0];
  datum.covariance.setIdentity();
  datum.origin = gprodom::Geodetic(52.0, 13.0, 40.0);
  return ground;
}

// What was driven since that ground was written, as a file.
inline std::string sound_newest(bool tied = false) {
  gprodom::GroundMap ground = sound_ground();
  const std::string whole = to_bytes(ground, ground.places);
  if (tied) ground.datums = tied_ground().datums;
  const gprodom::gpr::MemoryRange kept = ground.memory.kept();
  drive_on(ground, 250, 450);
  ground.memory.end_run();
  ground.places.push_back({kept.end + 5, 5.1, {}, 0});
  return newest_to_bytes(ground, ground.places, kept.first,
                         {gprodom::ground_head("", whole).identity, kept.first, kept.end});
}
