// The pieces that map files are made of: docs/map_format.md. For ground_map_file.cpp.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "base/sealed_bytes.h"
#include "map/ground_map.h"

namespace gprodom {

// Limit for the samples of a trace and the rows of a column; no radar has more.
constexpr std::uint32_t kMostSamples = 1U << 20U;

constexpr int kWithDatums = 5, kWithAntennas = 6;  // versions

// Each get_ function refuses what makes no sense (ByteReader::refuse()).
void put_format(const GroundMap& ground, ByteWriter& out);
void get_format(ByteReader& in, GroundMap& ground);

// Parents, and since version 4 what the ground comes from.
void put_descent(const GroundMap& ground, ByteWriter& out);
void get_descent(ByteReader& in, GroundMap& ground);

// Band limits of the memory's sessions, and their origins, which get_sessions() gives to the
// ground.
void put_sessions(const GroundMap& ground, int version, ByteWriter& out);
std::vector<gpr::BandLimit> get_sessions(ByteReader& in, GroundMap& ground);

// The runs of band-limited columns, from a column on, which may lie within a run.
void put_runs(const GroundMap& ground, std::size_t first, ByteWriter& out);
std::vector<gpr::StoredRun> get_runs(ByteReader& in, int rows);

std::vector<TimeNs> get_times(ByteReader& in, std::uint64_t columns);
double get_finite(ByteReader& in, const char* what);

// Columns are counted from `begin` in the file. Those read are checked by expect_places().
void put_places(const std::vector<KnownPlace>& places, std::size_t begin, ByteWriter& out);
std::vector<KnownPlace> get_places(ByteReader& in);
void expect_places(const ByteReader& in, const GroundMap& ground);

// Since version 5 (kWithDatums): where the maps lie in site.
void put_datums(const std::map<int, MapDatum>& datums, ByteWriter& out);
std::map<int, MapDatum> get_datums(ByteReader& in);

}  // namespace gprodom
