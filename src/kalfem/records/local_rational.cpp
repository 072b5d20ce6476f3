// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/local_rational.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/input_error.hpp"

namespace kalfem {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr double least_denominator = 1e-3;  ///< |A| against the largest in the window, in the weights
constexpr double worth_a_transient = 1.1;   ///< noise without it against noise with it

/// The lines of one window and the powers of r / half_width there.
struct Window {
  Index first = 0, size = 0;
  MatrixXd powers;  ///< lines x (order + 1)
};

Window window_about(Index line, Index lines, const LocalRationalOptions& options) {
  const Index size = std::min(2 * options.half_width + 1, lines);
  Window window{std::clamp<Index>(line - size / 2, 0, lines - size), size, MatrixXd::Ones(size, options.order + 1)};
  const double scale = static_cast<double>(std::max<Index>(1, size / 2));
  for (Index i = 0; i < size; ++i)
    for (Index p = 1; p <= options.order; ++p)
      window.powers(i, p) = window.powers(i, p - 1) * static_cast<double>(window.first + i - line) / scale;
  return window;
}

struct LocalFit {
  Complex response;
  double variance = 0.0;  ///< E |error of the response|^2
  double noise = 0.0;     ///< E |E|^2
};

/// One fit; nothing where its equations are singular.
std::optional<LocalFit> local_fit(const VectorXcd& input, const VectorXcd& output, const Window& window,
                                  const LocalRationalOptions& options, bool with_transient) {
  const Index n = window.size, order = options.order;
  const auto u = input.segment(window.first, n), y = output.segment(window.first, n);
  const double input_scale = u.cwiseAbs().maxCoeff(), scale = y.cwiseAbs().maxCoeff();
  if (!(input_scale > 0.0 && scale > 0.0)) return std::nullopt;
  const Index columns = order + (order + 1) * (with_transient ? 2 : 1);
  MatrixXcd equations(n, columns);
  equations.leftCols(order) = (y / -scale).asDiagonal() * window.powers.rightCols(order);
  equations.middleCols(order, order + 1) = (u / input_scale).asDiagonal() * window.powers;
  if (with_transient) equations.rightCols(order + 1) = window.powers.cast<Complex>();
  const double freedom = static_cast<double>(n - columns - order);
  VectorXd weight = VectorXd::Ones(n);
  LocalFit fit;
  for (int pass = 0; pass < options.passes; ++pass) {
    const VectorXcd right = weight.asDiagonal() * (y / scale);
    const Eigen::HouseholderQR<MatrixXcd> qr(weight.asDiagonal() * equations);
    const VectorXcd rotated = qr.householderQ().adjoint() * right;
    const auto factor = qr.matrixQR().topRows(columns).triangularView<Eigen::Upper>();
    const VectorXcd solution = factor.solve(rotated.head(columns));
    if (!solution.allFinite()) return std::nullopt;
    const VectorXcd denominator = VectorXcd::Ones(n) + window.powers.rightCols(order) * solution.head(order);
    const VectorXd size = denominator.cwiseAbs();
    const double power = rotated.tail(n - columns).squaredNorm() / freedom;
    fit.noise = scale * scale * power / size.cwiseProduct(weight).cwiseAbs2().mean();
    const VectorXcd row = factor.adjoint().solve(VectorXcd::Unit(columns, order));
    fit.response = solution[order] * scale / input_scale;
    fit.variance = power * row.squaredNorm() * std::pow(scale / input_scale, 2);
    weight = size.cwiseMax(least_denominator * size.maxCoeff()).cwiseInverse();
  }
  if (!std::isfinite(fit.noise) || !std::isfinite(fit.variance)) return std::nullopt;
  return fit;
}

/// The fits of an output at some lines.
using Fits = std::vector<std::optional<LocalFit>>;

Fits fits_at(const std::vector<Index>& centres, const RecordSpectra& spectra, Index output,
             const LocalRationalOptions& options, bool with_transient) {
  Fits fits;
  const VectorXcd values = spectra.outputs.col(output);
  for (const Index line : centres)
    fits.push_back(
        local_fit(spectra.input, values, window_about(line, spectra.lines.size(), options), options, with_transient));
  return fits;
}

/// Whether the noise is larger without the transient, in the mean over the lines of the logarithm.
bool needs_transient(const Fits& without, const Fits& with) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < with.size(); ++i) {
    if (!without[i]) return true;
    if (!with[i] || !(with[i]->noise > 0.0) || !(without[i]->noise > 0.0)) continue;
    sum += std::log(without[i]->noise / with[i]->noise);
    count += 1.0;
  }
  return count > 0.0 && sum > count * std::log(worth_a_transient);
}

/// Lines in the band, every so many that no more than `most` are fitted.
std::vector<Index> spread(Index first, Index count, Index most) {
  std::vector<Index> centres;
  const Index step = (count + most - 1) / most;
  for (Index k = 0; k < count; k += step) centres.push_back(first + k);
  return centres;
}

/// Means over the fits within `reach` lines: windows that overlap tell the same noise.
std::vector<double> averaged(const std::vector<Index>& at, const std::vector<double>& noise, Index reach) {
  std::vector<double> averages;
  for (std::size_t i = 0, begin = 0, end = 0; i < at.size(); ++i) {
    while (end < at.size() && at[end] <= at[i] + reach) ++end;
    while (at[begin] < at[i] - reach) ++begin;
    const auto near = std::span(noise).subspan(begin, end - begin);
    averages.push_back(std::accumulate(near.begin(), near.end(), 0.0) / static_cast<double>(near.size()));
  }
  return averages;
}

/// Noise at every line: averaged over a window, with what the input's error adds, linear between the fitted lines.
VectorXd interpolated_noise(const std::vector<Index>& centres, const Fits& fits, const VectorXd& input_error,
                            Index first, Index count, Index reach) {
  std::vector<Index> at;
  std::vector<double> noise;
  for (std::size_t i = 0; i < fits.size(); ++i)
    if (fits[i]) at.push_back(centres[i] - first), noise.push_back(fits[i]->noise);
  if (at.empty()) return VectorXd::Zero(count);
  noise = averaged(at, noise, reach);
  for (std::size_t i = 0, kept = 0; i < fits.size(); ++i)
    if (fits[i]) noise[kept++] += input_error[centres[i]] * std::norm(fits[i]->response);
  VectorXd all(count);
  std::size_t next = 0;
  for (Index k = 0; k < count; ++k) {
    while (next < at.size() && at[next] < k) ++next;
    if (next == 0 || next == at.size() || at[next] == k) {
      all[k] = noise[std::min(next, at.size() - 1)];
      continue;
    }
    const double part = static_cast<double>(k - at[next - 1]) / static_cast<double>(at[next] - at[next - 1]);
    all[k] = (1.0 - part) * noise[next - 1] + part * noise[next];
  }
  return all;
}

double mean_power(const RecordSpectra& spectra, Index output, const Window& window) {
  return spectra.outputs.col(output).segment(window.first, window.size).squaredNorm() /
         static_cast<double>(window.size);
}

}  // namespace

// For each output: fits at the lines of the band, with the transient and without; those without are kept where the
// noise is no larger, as then input and transient need not be told apart. Lines at which no output's fit is singular
// form the response; the noise is interpolated over the others.
LocalRationalFit fit_local_rational(const RecordSpectra& spectra, const FrequencyBand& band,
                                    const LocalRationalOptions& options) {
  const auto& lines = spectra.lines;
  const Index first = std::ranges::lower_bound(lines, band.from) - lines.begin();
  const Index count = (std::ranges::upper_bound(lines, band.to) - lines.begin()) - first;
  const Index fewest = 5 * options.order + 4;
  if (lines.size() < fewest || count < 1)
    throw InvalidInput("the record has " + std::to_string(std::max<Index>(0, count)) + " lines between " +
                           std::to_string(band.from) + " and " + std::to_string(band.to) + " Hz",
                       "a local fit needs at least one there, and " + std::to_string(fewest) + " in all",
                       "give a longer record or other bands");
  const auto centres = spread(first, count, options.most_lines);
  std::vector<Fits> all;
  for (Index j = 0; j < spectra.outputs.cols(); ++j) {
    Fits with = fits_at(centres, spectra, j, options, true), without = fits_at(centres, spectra, j, options, false);
    all.push_back(needs_transient(without, with) ? std::move(with) : std::move(without));
  }
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < centres.size(); ++i)
    if (std::ranges::all_of(all, [&](const Fits& fits) { return fits[i].has_value(); })) kept.push_back(i);
  const VectorXd input_error = input_error_power(spectra);
  const auto rows = std::ssize(kept), columns = spectra.outputs.cols();
  LocalRationalFit result{{VectorXd(rows), spectra.channels, MatrixXcd(rows, columns), MatrixXd(rows, columns), false,
                           MatrixXd(rows, columns)},
                          MatrixXd(count, columns)};
  for (Index j = 0; j < columns; ++j) {
    const Fits& fits = all[static_cast<std::size_t>(j)];
    result.noise.col(j) = interpolated_noise(centres, fits, input_error, first, count, options.half_width);
    for (Index i = 0; i < rows; ++i) {
      const std::size_t place = kept[static_cast<std::size_t>(i)];
      const LocalFit& fit = *fits[place];
      const Window window = window_about(centres[place], lines.size(), options);
      result.response.lines[i] = lines[centres[place]];
      result.response.values(i, j) = fit.response;
      result.response.deviations(i, j) = std::sqrt(0.5 * fit.variance);
      result.response.coherence(i, j) = std::clamp(1.0 - fit.noise / mean_power(spectra, j, window), 0.0, 1.0);
    }
  }
  return result;
}

}  // namespace kalfem
