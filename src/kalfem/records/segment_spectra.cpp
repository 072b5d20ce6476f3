// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/segment_spectra.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/record_spectra.hpp"

namespace kalfem {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

void check_options(const H1Options& options, IssueList& issues) {
  if (options.segment < 4)
    issues.add({}, "a segment is " + std::to_string(options.segment) + " samples long", "a spectrum needs at least 4",
               "use the sampling rate divided by the wanted line spacing");
  if (!(options.overlap >= 0.0 && options.overlap <= 0.95))
    issues.add({}, "segments overlap by " + std::to_string(options.overlap), "the overlap must lie in [0, 0.95]");
}

}  // namespace

void check_segments(std::span<const Record> records, const std::vector<std::string>& names, const H1Options& options) {
  IssueList issues;
  check_options(options, issues);
  Index longest = 0;
  for (const auto& record : records) {
    check_spectral_channels(record, names, issues);
    longest = std::max(longest, record.samples());
    if (std::abs(record.sample_rate / records.front().sample_rate - 1.0) > 1e-6)
      issues.add({},
                 "records are sampled at " + std::to_string(record.sample_rate) + " and " +
                     std::to_string(records.front().sample_rate) + " Hz",
                 "records can be averaged only if they have the same rate");
  }
  if (longest < options.segment)
    issues.add({},
               "the longest record has " + std::to_string(longest) + " samples, a segment has " +
                   std::to_string(options.segment),
               "at least one segment must fit into the record", "shorten the segment");
  issues.raise();
}

VectorXd window_of(const H1Options& options) {
  const Index n = options.segment;
  if (options.window == SpectralWindow::rectangular) return VectorXd::Ones(n);
  const double last = 2.0 * std::numbers::pi * double(n - 1) / double(n);
  return 0.5 - 0.5 * ArrayXd::LinSpaced(n, 0.0, last).cos();
}

Index hop_of(const H1Options& options) {
  return std::max<Index>(1, std::llround((1.0 - options.overlap) * double(options.segment)));
}

Index segments_in(const Record& record, const H1Options& options) {
  if (record.samples() < options.segment) return 0;
  return 1 + (record.samples() - options.segment) / hop_of(options);
}

MatrixXcd spectra_of(const Record& record, const std::vector<std::string>& names, Index first, const VectorXd& window) {
  const Index n = window.size(), lines = (n - 1) / 2;
  MatrixXcd spectra(lines, Index(names.size()));
  Eigen::FFT<double> transform;
  VectorXcd spectrum;
  for (Index j = 0; j < spectra.cols(); ++j) {
    const VectorXd samples = record.values.row(record.find(names[std::size_t(j)])).segment(first, n).transpose();
    const VectorXd windowed = (samples.array() - samples.mean()) * window.array();
    transform.fwd(spectrum, windowed);
    spectra.col(j) = spectrum.segment(1, lines);
  }
  return spectra;
}

double effective_averages(std::span<const Record> records, const VectorXd& window, const H1Options& options) {
  double total = 0.0, correlated = 0.0;
  for (const auto& record : records) total += double(segments_in(record, options));
  for (Index shift = hop_of(options), k = 1; shift < options.segment; shift += hop_of(options), ++k) {
    const Index shared = options.segment - shift;
    const double rho = window.head(shared).dot(window.tail(shared)) / window.squaredNorm();
    for (const auto& record : records)
      correlated += rho * rho * double(std::max<Index>(0, segments_in(record, options) - k));
  }
  return total * total / (total + 2.0 * correlated);
}

}  // namespace kalfem
