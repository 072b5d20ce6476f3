// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/signals/line_series.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstring>
#include <numbers>
#include <string>
#include <unsupported/Eigen/FFT>
#include <utility>

#include "kalfem/base/vector_loops.hpp"
#include "kalfem/system/option_checks.hpp"

namespace kalfem {

namespace {

constexpr Eigen::Index samples_per_block = 256;  // the table of 600 lines then fills 2.4 MB
constexpr Eigen::Index blocks_per_product = 64;  // bounds the memory of the coefficients
constexpr Eigen::Index strip = 16;               // samples whose sums stay in registers

typedef double Strip __attribute__((vector_size(strip * sizeof(double) / 2)));

/// 2 pi * fraction of (frequency * time): the product's rounding error is recovered by a fused multiply-add, so late
/// times keep their phase.
double angle(double frequency, double time) {
  const double cycles = frequency * time;
  const double rest = std::fma(frequency, time, -cycles);
  return 2.0 * std::numbers::pi * ((cycles - std::round(cycles)) + rest);
}

class SpectralLines final : public Signal {
public:
  explicit SpectralLines(std::vector<SpectralLine> lines) : lines_(std::move(lines)) {}

  SignalSamples sample(double start, double step, Eigen::Index count) const override {
    check_sampling(start, step, count);
    SignalSamples samples(count, 3);
    if (count == 0) return samples;
    const auto root = static_cast<Eigen::Index>(std::ceil(std::sqrt(double(count))));
    const Eigen::Index rows = std::min(samples_per_block, (root + strip - 1) / strip * strip);
    const Eigen::MatrixXd table = block_table(step, rows);
    const Eigen::Index blocks = (count + rows - 1) / rows;
    for (Eigen::Index first = 0; first < blocks; first += blocks_per_product) {
      const Eigen::Index some = std::min(blocks_per_product, blocks - first);
      const Eigen::MatrixXd coefficients = block_coefficients(start, step, rows, first, some);
      for (Eigen::Index within = 0; within < rows; within += strip)
        for (Eigen::Index b = 0; b < some; ++b) {
          const Eigen::Index row = (first + b) * rows + within, filled = std::min(strip, count - row);
          if (filled <= 0) break;
          const auto sums = strip_sums(&table(0, within / strip * 2 * size()), &coefficients(0, 3 * b));
          samples.middleRows(row, filled) = sums.topRows(filled);
        }
    }
    return samples;
  }

private:
  Eigen::Index size() const { return static_cast<Eigen::Index>(lines_.size()); }

  /// cos(w_l j step), sin(w_l j step) at samples j of a strip and all lines l, one strip after the other.
  Eigen::MatrixXd block_table(double step, Eigen::Index rows) const {
    Eigen::MatrixXd table(strip, rows / strip * 2 * size());
    for (Eigen::Index first = 0; first < rows; first += strip)
      for (Eigen::Index l = 0; l < size(); ++l)
        for (Eigen::Index j = 0; j < strip; ++j) {
          const double turned = angle(lines_[l].frequency, static_cast<double>(first + j) * step);
          const Eigen::Index column = first / strip * 2 * size() + l;
          table(j, column) = std::cos(turned);
          table(j, column + size()) = std::sin(turned);
        }
    return table;
  }

  /// The product of a strip of the table with the three columns of a block.
  Eigen::Array<double, strip, 3> strip_sums(const double* table, const double* coefficients) const {
    const Eigen::Index terms = 2 * size();
    Eigen::Array<double, strip, 3> sums;
    in_widest_registers([&]() KALFEM_INLINE {
      Strip upper[3] = {}, lower[3] = {};
      for (Eigen::Index l = 0; l < terms; ++l) {
        Strip here[2];
        std::memcpy(here, table + strip * l, sizeof here);
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) {
          upper[i] += here[0] * coefficients[l + i * terms];
          lower[i] += here[1] * coefficients[l + i * terms];
        }
      }
#pragma GCC unroll 3
      for (int i = 0; i < 3; ++i) {
        std::memcpy(sums.data() + strip * i, &upper[i], sizeof(Strip));
        std::memcpy(sums.data() + strip * i + strip / 2, &lower[i], sizeof(Strip));
      }
    });
    return sums;
  }

  /// Three columns (value, rate, acceleration) per block that begins at sample (first + b) * rows; 2 lines x 3 blocks.
  Eigen::MatrixXd block_coefficients(double start, double step, Eigen::Index rows, Eigen::Index first,
                                     Eigen::Index blocks) const {
    Eigen::MatrixXd coefficients(2 * size(), 3 * blocks);
    for (Eigen::Index b = 0; b < blocks; ++b) {
      const double time = start + static_cast<double>((first + b) * rows) * step;
      for (Eigen::Index l = 0; l < size(); ++l) {
        const auto& line = lines_[l];
        const double w = 2.0 * std::numbers::pi * line.frequency;
        const double phase = angle(line.frequency, time) + line.phase;
        const double s = line.amplitude * std::sin(phase);
        const double c = line.amplitude * std::cos(phase);
        coefficients.block<1, 3>(l, 3 * b) << s, w * c, -w * w * s;
        coefficients.block<1, 3>(size() + l, 3 * b) << c, -w * s, -w * w * c;
      }
    }
    return coefficients;
  }

  std::vector<SpectralLine> lines_;
};

}  // namespace

double amplitude_integrated_twice(double amplitude, double frequency) {
  const double w = 2.0 * std::numbers::pi * frequency;
  return -amplitude / (w * w);
}

SignalPtr make_spectral_lines(std::vector<SpectralLine> lines) {
  IssueList issues;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const std::string name = " of spectral line " + std::to_string(l + 1);
    require_finite(issues, "amplitude" + name, lines[l].amplitude);
    require_nonnegative(issues, "frequency" + name, lines[l].frequency);
    require_finite(issues, "phase" + name, lines[l].phase);
  }
  issues.raise();
  return std::make_shared<SpectralLines>(std::move(lines));
}

namespace {

using Eigen::Index;
using Complex = std::complex<double>;

/// Up to so many lines the sum over lines is as fast, and it has no error of interpolation.
constexpr std::size_t summed_lines = 1000;

// The window spans `width` points of the grid. On a grid twice as fine as the band, its shape beta = 0.74 pi width errs
// by 1e-15 of the value, 4e-15 of the rate and 2e-13 of the acceleration.
constexpr Index width = 18;
constexpr double beta = 0.74 * std::numbers::pi * static_cast<double>(width);
/// Of the polynomials that stand for the window between two points of the grid.
constexpr Index degree = 16;

using Weights = Eigen::Matrix<double, degree + 1, width>;
using Polynomial = Eigen::Matrix<Complex, degree + 1, 1>;

/// I0(beta sqrt(1 - (2x/width)^2)) for |x| <= width / 2; in more digits than the double's, which the second derivative
/// of the polynomials through it would lose.
long double window(long double x) {
  const long double z = 2.0L * x / static_cast<long double>(width);
  return std::cyl_bessel_i(0.0L, beta * std::sqrt(std::max(0.0L, 1.0L - z * z)));
}

/// Fourier transform of the window at so many cycles a point of the grid, |cycles| <= 1/4.
double window_spectrum(double cycles) {
  const double turned = std::numbers::pi * static_cast<double>(width) * cycles;
  const double root = std::sqrt(beta * beta - turned * turned);
  return static_cast<double>(width) * std::sinh(root) / root;
}

/// Column q: coefficients of the window's weight of the point q - width / 2 + 1 from the left end of an interval, a
/// polynomial in v = 2 (x - 1/2) over the interval 0 <= x <= 1, through Chebyshev points.
Weights window_polynomials() {
  constexpr int rows = degree + 1;
  Eigen::Matrix<long double, rows, rows> powers;
  Eigen::Matrix<long double, rows, width> values;
  for (Index i = 0; i <= degree; ++i) {
    const long double v = std::cos(std::numbers::pi_v<long double> * (static_cast<long double>(i) + 0.5L) / rows);
    for (Index d = 0; d <= degree; ++d) powers(i, d) = std::pow(v, static_cast<int>(d));
    for (Index q = 0; q < width; ++q)
      values(i, q) = window(0.5L * (v + 1.0L) + static_cast<long double>(width / 2 - 1 - q));
  }
  return powers.colPivHouseholderQr().solve(values).eval().cast<double>();
}

/// Value, first and second derivative of a polynomial at v.
struct PolynomialValue {
  Complex value, slope, curvature;
};

PolynomialValue evaluate(const Polynomial& coefficients, double v) {
  PolynomialValue p{coefficients[degree], 0.0, 0.0};
  for (Index d = degree - 1; d >= 0; --d) {
    p.curvature = p.curvature * v + p.slope;
    p.slope = p.slope * v + p.value;
    p.value = p.value * v + coefficients[d];
  }
  p.curvature *= 2.0;
  return p;
}

/// x(t) = Re[e(t) exp(i w_c t)] with e the envelope, a sum of lines between -1/4 and 1/4 cycle a point of its grid.
class TransformedLines final : public Signal {
public:
  explicit TransformedLines(const LineSeries& series) : period_(series.period), weights_(window_polynomials()) {
    const auto lines = static_cast<Index>(series.amplitude.size());
    const Index middle = lines / 2;
    centre_ = series.first + middle;
    const auto points = static_cast<Index>(std::bit_ceil(static_cast<std::size_t>(std::max(4 * middle, 2 * width))));
    Eigen::VectorXcd spectrum = Eigen::VectorXcd::Zero(points);
    for (Index l = 0; l < lines; ++l) {
      const Index m = l - middle;
      const auto at = static_cast<std::size_t>(l);
      const double height =
          series.amplitude[at] / window_spectrum(static_cast<double>(m) / static_cast<double>(points));
      spectrum[m < 0 ? m + points : m] = height * Complex(std::sin(series.phase[at]), -std::cos(series.phase[at]));
    }
    Eigen::FFT<double> transform;
    transform.SetFlag(Eigen::FFT<double>::Unscaled);
    transform.inv(grid_, spectrum);
  }

  SignalSamples sample(double start, double step, Index count) const override {
    check_sampling(start, step, count);
    SignalSamples samples(count, 3);
    const auto points = static_cast<double>(grid_.size());
    const double rate = 2.0 * points / period_, w = 2.0 * std::numbers::pi * static_cast<double>(centre_) / period_;
    Index known = -1;
    Polynomial envelope;
    for (Index k = 0; k < count; ++k) {
      const double periods = (start + static_cast<double>(k) * step) / period_;
      const double within = periods - std::floor(periods), position = within * points;
      const auto interval = static_cast<Index>(position);
      if (interval != known) envelope = envelope_over(known = interval);
      const auto [e, slope, curvature] = evaluate(envelope, 2.0 * (position - static_cast<double>(interval)) - 1.0);
      const Complex e1 = rate * slope, e2 = rate * rate * curvature, turn = carrier(within);
      const Complex i_w(0.0, w);
      samples.row(k) << (e * turn).real(), ((e1 + i_w * e) * turn).real(),
          ((e2 + 2.0 * i_w * e1 - w * w * e) * turn).real();
    }
    return samples;
  }

private:
  /// exp(i w_c t), at a part of the period; whole turns are taken off exactly.
  [[nodiscard]] Complex carrier(double within) const {
    const auto centre = static_cast<double>(centre_);
    const double cycles = centre * within, rest = std::fma(centre, within, -cycles);
    return std::polar(1.0, 2.0 * std::numbers::pi * ((cycles - std::round(cycles)) + rest));
  }

  /// The envelope between a point of the grid and the next one.
  [[nodiscard]] Polynomial envelope_over(Index interval) const {
    Polynomial sum = Polynomial::Zero();
    const Index points = grid_.size();
    for (Index q = 0; q < width; ++q) {
      const Index point = (interval + q - width / 2 + 1 + points) % points;
      sum += grid_[point] * weights_.col(q);
    }
    return sum;
  }

  double period_;
  Weights weights_;
  Index centre_ = 0;       ///< line about which the envelope stands
  Eigen::VectorXcd grid_;  ///< the envelope, divided by the window in the frequency domain, over one period
};

void check(const LineSeries& series) {
  IssueList issues;
  require_positive(issues, "period of the spectral lines [s]", series.period);
  if (series.first < 0)
    issues.add({}, "the first spectral line is number " + std::to_string(series.first), "it must not be negative");
  if (series.amplitude.size() != series.phase.size())
    issues.add({},
               std::to_string(series.amplitude.size()) + " amplitudes and " + std::to_string(series.phase.size()) +
                   " phases of spectral lines",
               "every line needs one of each");
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!std::ranges::all_of(series.amplitude, finite) || !std::ranges::all_of(series.phase, finite))
    issues.add({}, "an amplitude or phase of a spectral line is not finite", "the signal is their sum");
  issues.raise();
}

}  // namespace

SignalPtr make_line_series(LineSeries series) {
  check(series);
  if (series.amplitude.size() > summed_lines) return std::make_shared<TransformedLines>(series);
  std::vector<SpectralLine> lines;
  for (std::size_t l = 0; l < series.amplitude.size(); ++l) {
    const double frequency = static_cast<double>(series.first + static_cast<Index>(l)) / series.period;
    lines.push_back({series.amplitude[l], frequency, series.phase[l]});
  }
  return make_spectral_lines(std::move(lines));
}

SignalPtr make_transformed_lines(const LineSeries& series) {
  check(series);
  if (series.amplitude.empty()) throw InvalidInput("a series of no spectral lines", "it needs at least one", "");
  return std::make_shared<TransformedLines>(series);
}

}  // namespace kalfem
