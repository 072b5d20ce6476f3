// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/frequency_response.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/segment_spectra.hpp"

namespace kalfem {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// Lines of a peak that are fitted: those above this part of its height, and at least two on each side.
constexpr double fitted_height = 0.2;
constexpr Index least_neighbours = 2;
constexpr Index most_neighbours = 30;
constexpr int fit_passes = 5;

/// Sums over segments of the spectra's products at the lines below half the sampling rate, without line 0.
struct SpectralSums {
  VectorXd input;    ///< S_xx
  MatrixXd outputs;  ///< S_yy, lines x outputs
  MatrixXcd cross;   ///< S_xy = conj(X) Y, lines x outputs

  SpectralSums(Index lines, Index columns)
      : input(VectorXd::Zero(lines)), outputs(MatrixXd::Zero(lines, columns)), cross(MatrixXcd::Zero(lines, columns)) {}

  void add(const VectorXcd& x, const MatrixXcd& y) {
    input += x.cwiseAbs2();
    outputs += y.cwiseAbs2();
    cross += x.conjugate().asDiagonal() * y;
  }
};

/// H1 with its coherence and deviation at the lines where the input has power.
H1Estimate estimate_of(const SpectralSums& sums, double spacing, double averages) {
  const double least = 1e-24 * sums.input.maxCoeff();
  std::vector<Index> kept;
  for (Index k = 0; k < sums.input.size(); ++k)
    if (sums.input[k] > least) kept.push_back(k);
  const MatrixXd power = sums.outputs(kept, Eigen::all);
  const VectorXd weight = sums.input(kept).cwiseInverse();
  H1Estimate estimate;
  estimate.averages = averages;
  auto& [lines, outputs, values, deviations, magnitudes_only, coherence] = estimate.response;
  lines.resize(Index(kept.size()));
  for (Index i = 0; i < lines.size(); ++i) lines[i] = spacing * double(kept[std::size_t(i)] + 1);
  values = weight.asDiagonal() * sums.cross(kept, Eigen::all);
  const MatrixXd coherent = sums.input(kept).asDiagonal() * values.cwiseAbs2();
  coherence = (power.array() > 0.0).select(coherent.array() / power.array(), 0.0).min(1.0);
  if (averages > 1.0 + 1e-9)
    deviations = (weight.asDiagonal() * (power - coherent).cwiseMax(0.0) / (2.0 * (averages - 1.0))).cwiseSqrt();
  return estimate;
}

/// Height of each line: root mean square over the columns.
VectorXd heights_of(const FrequencyResponse& response) {
  return (response.values.cwiseAbs2().rowwise().mean()).cwiseSqrt();
}

/// Lowest height from the peak towards one side, until a higher line or the end of the band.
double valley(const VectorXd& heights, Index peak, Index step) {
  double lowest = heights[peak];
  for (Index k = peak + step; k >= 0 && k < heights.size() && heights[k] <= heights[peak]; k += step)
    lowest = std::min(lowest, heights[k]);
  return lowest;
}

bool stands_out(const VectorXd& heights, Index k, double prominence) {
  const bool highest_near = heights[k] > heights[k - 1] && heights[k] >= heights[k + 1];
  return highest_near && heights[k] >= prominence * std::max(valley(heights, k, -1), valley(heights, k, +1));
}

/// The contiguous lines about a peak that its pole is fitted to.
std::pair<Index, Index> fitted_lines(const VectorXd& heights, Index peak) {
  const auto reach = [&](Index step) {
    Index k = 0;
    for (Index next = peak + step; next >= 0 && next < heights.size() && k < most_neighbours; next += step, ++k)
      if (k >= least_neighbours && heights[next] < fitted_height * heights[peak]) break;
    return k;
  };
  const Index first = peak - reach(-1);
  return {first, peak + reach(+1) - first + 1};
}

/// p of H_j = (a_j + b_j x) / (x - p) over some lines; each pass weighs the equation error by 1 / |x - p| of the last,
/// which makes it the error of H. x is scaled by its value at the peak.
std::complex<double> fit_pole(const VectorXd& x, const MatrixXcd& values) {
  const Index lines = x.size(), columns = values.cols();
  std::complex<double> pole = 1.0;
  VectorXd weight = VectorXd::Ones(lines);
  for (int pass = 0; pass < fit_passes; ++pass) {
    MatrixXcd equations = MatrixXcd::Zero(lines * columns, 1 + 2 * columns);
    VectorXcd right(lines * columns);
    for (Index j = 0; j < columns; ++j) {
      const auto rows = Eigen::seqN(j * lines, lines);
      equations(rows, 0) = weight.asDiagonal() * values.col(j);
      equations(rows, 1 + 2 * j) = weight.cast<std::complex<double>>();
      equations(rows, 2 + 2 * j) = weight.cwiseProduct(x - VectorXd::Ones(lines)).cast<std::complex<double>>();
      right(rows) = weight.cwiseProduct(x).asDiagonal() * values.col(j);
    }
    pole = equations.colPivHouseholderQr().solve(right)[0];
    weight = (x.cast<std::complex<double>>().array() - pole).abs().max(1e-12).inverse();
  }
  return pole;
}

/// Place of the maximum of the parabola through the logarithms of three heights.
double parabola_peak(const VectorXd& lines, const VectorXd& heights, Index k) {
  const double left = std::log(heights[k - 1]), middle = std::log(heights[k]), right = std::log(heights[k + 1]);
  const double curvature = left - 2.0 * middle + right;
  const double shift = curvature < 0.0 && std::isfinite(curvature) ? 0.5 * (left - right) / curvature : 0.0;
  return lines[k] + shift * 0.5 * (lines[k + 1] - lines[k - 1]);
}

// Refines a peak of the sampled magnitude in two steps. The parabola gives a frequency without damping. The fitted
// pole p = (f_r / f_k)^2 (1 + 2 i zeta) gives both, and is used if it is damped and lies among the fitted lines. With
// magnitudes alone there is no phase to fit a pole to.
ResponsePeak refined(const FrequencyResponse& response, const VectorXd& heights, Index k) {
  const ResponsePeak rough{parabola_peak(response.lines, heights, k), {}};
  if (response.magnitudes_only) return rough;
  const auto [first, count] = fitted_lines(heights, k);
  const VectorXd lines = response.lines.segment(first, count);
  const double centre = response.lines[k];
  const auto pole = fit_pole((lines / centre).cwiseAbs2(), response.values.middleRows(first, count));
  if (!(pole.real() > 0.0 && pole.imag() > 0.0)) return rough;
  const double frequency = centre * std::sqrt(pole.real());
  if (!(frequency >= lines[0] && frequency <= lines[count - 1])) return rough;
  return {frequency, 0.5 * pole.imag() / pole.real()};
}

}  // namespace

H1Estimate estimate_h1(std::span<const Record> records, const std::string& input,
                       const std::vector<std::string>& outputs, const H1Options& options) {
  std::vector<std::string> names = {input};
  names.insert(names.end(), outputs.begin(), outputs.end());
  check_segments(records, names, options);
  const VectorXd window = window_of(options);
  SpectralSums sums((options.segment - 1) / 2, Index(outputs.size()));
  Index segments = 0;
  for (const auto& record : records)
    for (Index i = 0; i < segments_in(record, options); ++i, ++segments) {
      const MatrixXcd spectra = spectra_of(record, names, i * hop_of(options), window);
      sums.add(spectra.col(0), spectra.rightCols(spectra.cols() - 1));
    }
  const Record& first = records.front();
  H1Estimate estimate =
      estimate_of(sums, first.sample_rate / double(options.segment), effective_averages(records, window, options));
  estimate.segments = segments;
  for (const auto& name : outputs) estimate.response.outputs.push_back(first.channels[std::size_t(first.find(name))]);
  return estimate;
}

std::vector<ResponsePeak> find_peaks(const FrequencyResponse& response, const PeakOptions& options) {
  const VectorXd all = heights_of(response);
  const auto* begin = response.lines.data();
  const auto* end = begin + response.lines.size();
  const Index first = std::lower_bound(begin, end, options.band.from) - begin;
  const Index last = std::upper_bound(begin, end, options.band.to) - begin;
  if (last - first < 2 * least_neighbours + 1) return {};
  const VectorXd heights = all.segment(first, last - first);
  double highest = 0.0;
  std::vector<Index> peaks;
  for (Index k = least_neighbours; k < heights.size() - least_neighbours; ++k)
    if (stands_out(heights, k, options.prominence)) {
      peaks.push_back(k);
      highest = std::max(highest, heights[k]);
    }
  std::vector<ResponsePeak> found;
  for (const Index k : peaks)
    if (heights[k] >= options.least * highest) found.push_back(refined(response, all, first + k));
  return found;
}

}  // namespace kalfem
