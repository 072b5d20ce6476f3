// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/record_spectra.hpp"

#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/FFT>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr Index fewest_samples = 128;
constexpr double edge_part = 0.02;    ///< of the samples, at each end
constexpr Index least_edge = 8;       ///< samples
constexpr double least_level = 1e-9;  ///< of an edge, of the channel's rms

/// The largest 2^a 3^b 5^c that is not above n.
Index fast_length_within(Index n) {
  for (;; --n) {
    Index rest = n;
    for (const Index factor : {2, 3, 5})
      while (rest % factor == 0) rest /= factor;
    if (rest == 1) return n;
  }
}

void check(const Record& record, const std::vector<std::string>& names) {
  IssueList issues;
  check_spectral_channels(record, names, issues);
  if (record.samples() < fewest_samples)
    issues.add({}, "the record has " + std::to_string(record.samples()) + " samples",
               "a frequency response needs at least " + std::to_string(fewest_samples));
  issues.raise();
}

VectorXcd lines_of(const VectorXd& samples, Index lines) {
  Eigen::FFT<double> transform;
  VectorXcd spectrum;
  transform.fwd(spectrum, samples);
  return spectrum.segment(1, lines);
}

double edge_level(const VectorXd& samples) {
  const Index n = std::max(least_edge, static_cast<Index>(edge_part * static_cast<double>(samples.size())));
  const double both = (samples.head(n).squaredNorm() + samples.tail(n).squaredNorm()) / static_cast<double>(n);
  return std::max(std::sqrt(2.0 * both), least_level * rms(samples));
}

}  // namespace

void check_spectral_channels(const Record& record, const std::vector<std::string>& names, IssueList& issues) {
  std::vector<std::string> known;
  for (const auto& channel : record.channels) known.push_back(channel.name);
  for (const auto& name : names)
    if (record.find(name) < 0)
      issues.add({}, "the record has no channel '" + name + "'" + did_you_mean(name, known));
    else if (!record.values.row(record.find(name)).allFinite())
      issues.add({}, "channel '" + name + "' holds values that are not finite", "a spectrum needs every sample");
}

RecordSpectra record_spectra(const Record& record, const std::string& input, const std::vector<std::string>& outputs) {
  std::vector<std::string> names = outputs;
  names.push_back(input);
  check(record, names);
  const Index n = fast_length_within(record.samples()), lines = (n - 1) / 2;
  const auto channel = [&](const std::string& name) -> VectorXd {
    const VectorXd samples = record.values.row(record.find(name)).head(n).transpose();
    return samples.array() - samples.mean();
  };
  RecordSpectra spectra{.sample_rate = record.sample_rate,
                        .samples = n,
                        .lines = VectorXd::LinSpaced(lines, 1.0, static_cast<double>(lines)) *
                                 (record.sample_rate / static_cast<double>(n)),
                        .input = lines_of(channel(input), lines),
                        .outputs = Eigen::MatrixXcd(lines, std::ssize(outputs)),
                        .edges = VectorXd(std::ssize(outputs)),
                        .channels = {}};
  for (Index j = 0; j < spectra.outputs.cols(); ++j) {
    const std::string& name = outputs[static_cast<std::size_t>(j)];
    const VectorXd samples = channel(name);
    spectra.outputs.col(j) = lines_of(samples, lines);
    spectra.edges[j] = edge_level(samples);
    spectra.channels.push_back(record.channels[static_cast<std::size_t>(record.find(name))]);
  }
  return spectra;
}

}  // namespace kalfem
