// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/frf_leakage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace kalfem {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double edge_deviations = 3.0;  ///< prior of a mode's amplitude, in the motion at the ends of the record
constexpr double below = 0.5;            ///< of the first line: a lower mode is part of the smooth background
constexpr double above = 1.5;            ///< of the last line: and a higher one
constexpr double free_factor = 1e3;      ///< prior of a free scale
constexpr double known_gain = 0.01;      ///< prior of the input's gain
constexpr Index of_input = 4;            ///< columns of the input's factor
constexpr int degree = 2;                ///< of the smooth background
constexpr double run_ends = 3.0;         ///< lines further apart than so many times the closest begin another run

Complex laplace(double line) { return {0.0, 2.0 * pi * line}; }

/// 1 % of gain; x^2 and x^4 of an input that is no band-limited signal between its samples (linear there: the factor is
/// (sin(pi x / 2) / (pi x / 2))^2, -0.8 x^2 in front); i x of a delay, of 0.3 samples.
std::array<Complex, of_input> input_shapes(double line, double half_rate) {
  const double x = line / half_rate;
  return {known_gain, x * x, x * x * x * x, Complex(0.0, x)};
}

/// Sets of lines that follow each other without a gap: first and size.
std::vector<std::pair<Index, Index>> runs_of(const VectorXd& lines) {
  std::vector<std::pair<Index, Index>> runs;
  const Index n = lines.size();
  const double closest = n > 1 ? (lines.tail(n - 1) - lines.head(n - 1)).minCoeff() : 1.0;
  for (Index k = 0, first = 0; k < n; ++k)
    if (k + 1 == n || lines[k + 1] - lines[k] > run_ends * closest) {
      runs.emplace_back(first, k + 1 - first);
      first = k + 1;
    }
  return runs;
}

}  // namespace

// Columns in this order: p_0 and omega p_1 of each mode that is free; the polynomial's coefficients, Re and Im, and the
// ramp, of each output; free factors; aliases; the input's factor. The alias of an output is the answer about the
// sampling rate to an input that is no band-limited signal: its lines there are those about 0 times x^2 or less. A unit
// amplitude at an output has the transform rate / s in the discrete spectra, which gives the priors their units.
LeakageColumns::LeakageColumns(const FrfEvaluation& evaluation, std::size_t set, const ComparedSpectra& spectra,
                               FrfScale scale)
    : outputs_(spectra.outputs.cols()), shapes_(evaluation.basis.size()), half_rate_(0.5 * spectra.sample_rate) {
  find_modes(evaluation, set, spectra);
  for (Index j = 0; j < outputs_ && scale != FrfScale::fixed; ++j) {
    if (scale == FrfScale::per_response || scaled_.empty()) scaled_.emplace_back();
    scaled_.back().push_back(j);
  }
  const auto runs = std::ssize(runs_of(spectra.lines));
  const Index of_modes = 2 * std::ssize(modes_), smooth = outputs_ * (runs * 2 * (degree + 1) + 1);
  forced_.resize(spectra.lines.size(), outputs_);
  const Index of_factors = of_modes + smooth, of_aliases = of_factors + std::ssize(scaled_);
  columns_ = MatrixXd::Zero(2 * spectra.outputs.size(), of_aliases + outputs_ + of_input);
  const Complex at_rate = laplace(spectra.sample_rate);
  const VectorXd beyond = (evaluation.transfer(set, at_rate) * evaluation.load(set, at_rate)).cwiseAbs();
  for (Index k = 0; k < spectra.lines.size(); ++k) {
    const Complex s = laplace(spectra.lines[k]);
    const MatrixXcd transfer = evaluation.transfer(set, s);
    const auto shapes = input_shapes(spectra.lines[k], half_rate_);
    forced_.row(k) = (spectra.input[k] * (transfer * evaluation.load(set, s))).transpose();
    for (Index j = 0; j < outputs_; ++j) {
      const Index row = 2 * (k * outputs_ + j);
      const auto put = [&](Index column, Complex value) {
        columns_(row, column) = value.real() / spectra.deviations(k, j);
        columns_(row + 1, column) = value.imag() / spectra.deviations(k, j);
      };
      for (Index i = 0; i < std::ssize(modes_); ++i) {
        const FreeMode& mode = modes_[static_cast<std::size_t>(i)];
        put(2 * i, mode.prior * transfer(j, mode.shape));
        put(2 * i + 1, mode.prior / mode.omega * s * transfer(j, mode.shape));
      }
      for (Index i = 0; i < std::ssize(scaled_); ++i)
        if (std::ranges::find(scaled_[static_cast<std::size_t>(i)], j) != scaled_[static_cast<std::size_t>(i)].end())
          put(of_factors + i, free_factor * forced_(k, j));
      put(of_aliases + j, std::pow(spectra.lines[k] / half_rate_, 2) * beyond[j] * spectra.input[k]);
      for (Index i = 0; i < of_input; ++i)
        put(columns_.cols() - of_input + i, shapes[static_cast<std::size_t>(i)] * forced_(k, j));
    }
  }
  add_smooth_parts(spectra, of_modes);
}

// A mode of shape phi_j at the outputs and mass m has the transform s^(q - p) phi_j (p_0 + s p_1) / (m (s^2 + ...)), an
// amplitude of |phi_j| omega^(q - p - 1) |p_0 + i omega p_1| / m in time and of that times the sampling rate in the
// discrete spectra. Its prior is that of the output at which the record's ends leave least room.
void LeakageColumns::find_modes(const FrfEvaluation& evaluation, std::size_t set, const ComparedSpectra& spectra) {
  const VectorXd omegas = evaluation.basis.circular_frequencies();
  const double lowest = below * 2.0 * pi * spectra.lines[0], highest = above * 2.0 * pi * spectra.lines.tail(1)[0];
  for (Index i = 0; i < evaluation.basis.modes; ++i) {
    if (!(omegas[i] >= lowest && omegas[i] <= highest) || !(omegas[i] > 0.0)) continue;
    const VectorXd unit = evaluation.sets[set].outputs.col(i).cwiseAbs() *
                          std::pow(omegas[i], evaluation.sets[set].order - 1) /
                          (evaluation.basis.mass[i] * spectra.sample_rate);
    const double largest = unit.cwiseQuotient(spectra.edges).maxCoeff();
    if (largest > 0.0) modes_.push_back({i, omegas[i], edge_deviations / largest});
  }
}

void LeakageColumns::add_smooth_parts(const ComparedSpectra& spectra, Index first) {
  const double lowest = spectra.lines[0];
  Index column = first;
  for (Index j = 0; j < outputs_; ++j) {
    const double prior = edge_deviations * spectra.edges[j] * spectra.sample_rate / (2.0 * pi * lowest);
    const auto row = [&](Index k) { return 2 * (k * outputs_ + j); };
    for (const auto& [begin, count] : runs_of(spectra.lines)) {
      const double from = spectra.lines[begin], to = spectra.lines[begin + count - 1];
      for (Index k = begin; k < begin + count; ++k) {
        const double x = to > from ? 2.0 * (spectra.lines[k] - from) / (to - from) - 1.0 : 0.0;
        for (int power = 0; power <= degree; ++power)
          for (Index part = 0; part < 2; ++part)
            columns_(row(k) + part, column + 2 * power + part) = prior * std::pow(x, power) / spectra.deviations(k, j);
      }
      column += 2 * (degree + 1);
    }
    for (Index k = 0; k < spectra.lines.size(); ++k)
      columns_(row(k) + 1, column) = prior * lowest / (spectra.lines[k] * spectra.deviations(k, j));
    ++column;
  }
}

VectorXcd LeakageColumns::load(const VectorXd& amplitudes, Complex s) const {
  VectorXcd load = VectorXcd::Zero(shapes_);
  for (Index i = 0; i < std::ssize(modes_); ++i) {
    const FreeMode& mode = modes_[static_cast<std::size_t>(i)];
    load[mode.shape] += mode.prior * (amplitudes[2 * i] + s / mode.omega * amplitudes[2 * i + 1]);
  }
  return load;
}

Complex LeakageColumns::input_factor(const VectorXd& amplitudes, double line) const {
  const auto shapes = input_shapes(line, half_rate_);
  return 1.0 + std::inner_product(shapes.begin(), shapes.end(), amplitudes.tail(of_input).begin(), Complex());
}

VectorXd LeakageColumns::factors(const VectorXd& amplitudes) const {
  VectorXd factors = VectorXd::Ones(outputs_);
  const Index first = columns_.cols() - std::ssize(scaled_) - outputs_ - of_input;
  for (Index i = 0; i < std::ssize(scaled_); ++i)
    for (const Index j : scaled_[static_cast<std::size_t>(i)]) factors[j] += free_factor * amplitudes[first + i];
  return factors;
}

LeakageProjection::LeakageProjection(const MatrixXd& columns)
    : qr_(columns),
      svd_(MatrixXd(qr_.matrixQR().topRows(columns.cols()).triangularView<Eigen::Upper>()),
           Eigen::ComputeFullU | Eigen::ComputeFullV) {}

MatrixXd LeakageProjection::whitened(MatrixXd columns) const {
  const Index count = svd_.singularValues().size();
  columns.applyOnTheLeft(qr_.householderQ().adjoint());
  const VectorXd shrinkage = (1.0 + svd_.singularValues().array().square()).rsqrt();
  columns.topRows(count) =
      svd_.matrixU() * (shrinkage.asDiagonal() * (svd_.matrixU().transpose() * columns.topRows(count))).eval();
  columns.applyOnTheLeft(qr_.householderQ());
  return columns;
}

VectorXd LeakageProjection::amplitudes(const VectorXd& residual) const {
  const auto& values = svd_.singularValues().array();
  const VectorXd rotated = (qr_.householderQ().adjoint() * residual).head(values.size());
  const VectorXd gain = -values / (1.0 + values.square());
  return svd_.matrixV() * (gain.asDiagonal() * (svd_.matrixU().transpose() * rotated));
}

}  // namespace kalfem
