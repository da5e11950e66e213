// Daubechies' filters by spectral factorisation (I. Daubechies, Ten Lectures on Wavelets, ch. 6,
// 8).
#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>

#include "gpr/filter/wavelet.h"

namespace gprodom::gpr {
namespace {

using Complex = std::complex<double>;
using Zeros = std::vector<Complex>;  // of one real zero, or of a conjugate pair

// sum_{k<N} C(N-1+k, k) y^k, of which |H|^2 = 2 cos^2N(w/2) P(sin^2(w/2)); lowest power first.
std::vector<double> daubechies_polynomial(int order) {
  std::vector<double> p(order, 1.0);
  for (int k = 1; k < order; ++k) p[k] = p[k - 1] * (order - 1 + k) / k;
  return p;
}

// All roots at once (Durand-Kerner): the polynomials have simple roots and degree 7 at most.
std::vector<Complex> roots(const std::vector<double>& p) {
  const int degree = static_cast<int>(p.size()) - 1;
  std::vector<Complex> result(std::max(degree, 0));
  for (int k = 0; k < degree; ++k) result[k] = std::pow(Complex(0.4, 0.9), k);
  for (int iteration = 0; iteration < 200; ++iteration) {
    for (int i = 0; i < degree; ++i) {
      Complex value = 0.0, others = p[degree];
      for (int k = degree; k >= 0; --k) value = value * result[i] + p[k];
      for (int j = 0; j < degree; ++j) {
        if (j != i) others *= result[i] - result[j];
      }
      result[i] -= value / others;
    }
  }
  return result;
}

// Zeros within the unit circle, z + 1/z = 2 - 4y, real ones and conjugate pairs together.
std::vector<Zeros> zeros_inside(int order) {
  std::vector<Zeros> result;
  for (const Complex& y : roots(daubechies_polynomial(order))) {
    if (y.imag() < -1e-9) continue;  // comes with its conjugate
    const Complex b = 2.0 - 4.0 * y;
    Complex z = 0.5 * (b + std::sqrt(b * b - 4.0));
    if (std::abs(z) > 1.0) z = 1.0 / z;
    if (y.imag() < 1e-9) {
      result.emplace_back(1, z);
    } else {
      result.push_back({z, std::conj(z)});
    }
  }
  return result;
}

// (1 + z)^order prod (z - zero), scaled to the sum sqrt(2).
std::vector<double> synthesis_low_pass(int order, const Zeros& zeros) {
  std::vector<Complex> h{1.0};
  const auto multiply = [&h](Complex c) {  // by (1 + c z)
    h.emplace_back(0.0);
    for (std::size_t i = h.size() - 1; i > 0; --i) h[i] += c * h[i - 1];
  };
  for (int k = 0; k < order; ++k) multiply(1.0);
  for (const Complex& zero : zeros) multiply(-zero);
  Complex sum = 0.0;
  for (const Complex& value : h) sum += value;
  std::vector<double> result;
  result.reserve(h.size());
  for (const Complex& value : h) result.push_back((value * std::sqrt(2.0) / sum).real());
  return result;
}

// Mean squared deviation of the phase from the straight line through the origin that fits it best.
double phase_nonlinearity(const std::vector<double>& h) {
  constexpr int kSteps = 512;
  double wp = 0.0, ww = 0.0, pp = 0.0, phase = 0.0;
  Complex before = 1.0;
  for (int k = 1; k < kSteps; ++k) {
    const double w = M_PI * k / kSteps;
    Complex response = 0.0;
    for (std::size_t j = 0; j < h.size(); ++j) {
      response += h[j] * std::polar(1.0, -w * static_cast<double>(j));
    }
    phase += std::arg(response / before);
    before = response;
    wp += w * phase;
    ww += w * w;
    pp += phase * phase;
  }
  return pp - wp * wp / ww;
}

// Chooses each zero inside or outside the unit circle so that the phase is as linear as possible. A
// filter and its mirror image are equally good; takes the one whose centre of mass is right of its
// middle.
std::vector<double> least_asymmetric(int order) {
  const std::vector<Zeros> groups = zeros_inside(order);
  std::vector<double> best;
  double smallest = 0.0;
  for (unsigned choice = 0; choice < 1u << groups.size(); ++choice) {
    Zeros zeros;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      for (const Complex& z : groups[g]) zeros.push_back((choice >> g & 1u) != 0 ? 1.0 / z : z);
    }
    const std::vector<double> h = synthesis_low_pass(order, zeros);
    double centre = 0.0;
    for (std::size_t j = 0; j < h.size(); ++j) centre += static_cast<double>(j) * h[j];
    if (centre < std::sqrt(2.0) * (order - 0.5)) continue;
    const double nonlinearity = phase_nonlinearity(h);
    if (best.empty() || nonlinearity < smallest) {
      best = h;
      smallest = nonlinearity;
    }
  }
  return best;
}

std::vector<double> extremal_phase(int order) {
  Zeros zeros;
  for (const Zeros& group : zeros_inside(order)) {
    zeros.insert(zeros.end(), group.begin(), group.end());
  }
  return synthesis_low_pass(order, zeros);
}

}  // namespace

Wavelet make_wavelet(WaveletKind kind) {
  if (kind == WaveletKind::kNone) throw std::invalid_argument("wavelet: expected one, got none");
  const std::string name = name_of(kind);  // its last letter is the order
  const int order = name.back() - '0';
  const std::vector<double> synthesis =
      kind < WaveletKind::kSym4 ? extremal_phase(order) : least_asymmetric(order);
  Wavelet wavelet;
  wavelet.low.assign(synthesis.rbegin(), synthesis.rend());
  for (std::size_t j = 0; j < synthesis.size(); ++j) {
    wavelet.high.push_back((j % 2 == 0 ? -1.0 : 1.0) * synthesis[j]);
  }
  return wavelet;
}

}  // namespace gprodom::gpr
