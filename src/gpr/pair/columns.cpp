#include "gpr/pair/columns.h"

#include <algorithm>
#include <cmath>

namespace gprodom::gpr {

namespace {

// m; well below the shortest wave along the track that an antenna sees, which is a quarter of a
// wavelength in the ground (3 cm at 900 MHz).
constexpr double kColumn = 0.008;

}  // namespace

void AntennaColumns::add(TimeNs time, Eigen::VectorXf spectra) {
  recent_.push_back({time, spectra});
  while (recent_.front().time < time - Run::kLongestSteady) recent_.pop_front();
  waiting_.push_back({time, std::move(spectra)});
}

void AntennaColumns::clear() {
  waiting_.clear();
  recent_.clear();
  columns_.clear();
  traces_ = 0;
}

void AntennaColumns::forget_before(TimeNs time) {
  while (columns_.size() > 1 && columns_.front().time < time) columns_.pop_front();
}

void AntennaColumns::collect(const Travel& travel) {
  for (Column& trace : waiting_) {
    const bool same_place = !columns_.empty() && traces_ > 0 &&
                            std::abs(travel.at(trace.time) - travel.at(first_)) < kColumn;
    if (!same_place) {
      first_ = trace.time;
      traces_ = 1;
      columns_.push_back(std::move(trace));
      continue;
    }
    Column& column = columns_.back();
    ++traces_;
    column.time += (trace.time - column.time) / traces_;
    column.spectra += (trace.spectra - column.spectra) / static_cast<float>(traces_);
  }
  waiting_.clear();
}

bool AntennaColumns::sample(const Run& run, double begin, double spacing, Eigen::Index count,
                            ColumnMatrix& rows) const {
  std::vector<double> place;
  std::vector<const Eigen::VectorXf*> spectra;
  const double least = run.steady() ? 0.0 : 0.25 * kColumn;  // room to interpolate
  for (const Column& column : run.steady() ? recent_ : columns_) {
    if (column.time < run.begin()) continue;
    const double s = run.at(column.time);
    if (!place.empty() && s <= place.back() + least) continue;
    place.push_back(s);
    spectra.push_back(&column.spectra);
  }
  const double end = begin + spacing * static_cast<double>(count - 1);
  if (place.size() < 4 || place.front() > begin || place.back() < end) return false;
  rows.resize(count, spectra.front()->size());
  std::size_t i = 0;
  for (Eigen::Index row = 0; row < count; ++row) {
    const double s = begin + spacing * static_cast<double>(row);
    while (i + 2 < place.size() && place[i + 1] < s) ++i;
    const std::size_t before = i == 0 ? 0 : i - 1, after = std::min(i + 2, place.size() - 1);
    const double h = place[i + 1] - place[i], u = (s - place[i]) / h, u2 = u * u, u3 = u2 * u;
    const double ma = (u3 - 2 * u2 + u) * h / (place[i + 1] - place[before]);
    const double mb = (u3 - u2) * h / (place[after] - place[i]);
    const double a = 2 * u3 - 3 * u2 + 1, b = 3 * u2 - 2 * u3;
    rows.row(row) =
        (static_cast<float>(a - mb) * *spectra[i] + static_cast<float>(b + ma) * *spectra[i + 1] -
         static_cast<float>(ma) * *spectra[before] + static_cast<float>(mb) * *spectra[after])
            .transpose();
  }
  return true;
}

}  // namespace gprodom::gpr
