// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/spectral_modes.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "kalfem/base/interruption.hpp"
#include "kalfem/modal/shape_measures.hpp"
#include "kalfem/records/windowed_transform.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr double least_mac = 0.8;

/// Lines of a spectrum around a mode.
struct LineRange {
  Index first = 0, count = 0;
};

double half_power_bandwidth(const IdentifiedMode& mode) { return 2.0 * mode.damping * mode.frequency; }

/// A power of two, so that modes of about the same bandwidth share their spectra.
Index segment_length(const Record& record, const IdentifiedMode& mode) {
  const double wanted = 4.0 * record.sample_rate / half_power_bandwidth(mode);
  const auto most = static_cast<double>(std::max<Index>(record.samples() / 10, 16));
  return static_cast<Index>(std::exp2(std::floor(std::log2(std::min(most, std::max(256.0, wanted))))));
}

/// Cross-spectral matrices of the lines of each range, in any one scale.
std::vector<std::vector<MatrixXcd>> cross_spectra(const Record& record, const VectorXd& scale, Index segment,
                                                  const std::vector<LineRange>& ranges, WindowedTransform& transform) {
  const Index channels = scale.size();
  std::vector<std::vector<MatrixXcd>> spectra;
  for (const auto& range : ranges)
    spectra.emplace_back(static_cast<std::size_t>(range.count), MatrixXcd::Zero(channels, channels));
  MatrixXcd lines;
  for (Index begin = 0; begin + segment <= record.samples(); begin += segment / 2) {
    stop_if_asked();
    for (Index row = 0; row < channels; ++row) {
      const auto& spectrum = transform(record.values.row(row).segment(begin, segment).transpose() / scale[row]);
      lines.resize(channels, spectrum.size());
      lines.row(row) = spectrum.transpose();
    }
    for (std::size_t r = 0; r < ranges.size(); ++r)
      for (Index i = 0; i < ranges[r].count; ++i) {
        const auto line = lines.col(ranges[r].first + i);
        spectra[r][static_cast<std::size_t>(i)].noalias() += line * line.adjoint();
      }
  }
  return spectra;
}

/// The highest peak of the first singular value whose vector agrees with the shape.
std::optional<SpectralMode> highest_peak(const std::vector<MatrixXcd>& spectra, const LineRange& range, double spacing,
                                         const VectorXcd& shape) {
  VectorXd values(range.count);
  std::vector<double> agreement;
  for (Index i = 0; i < range.count; ++i) {
    const Eigen::SelfAdjointEigenSolver<MatrixXcd> eigen(spectra[static_cast<std::size_t>(i)]);
    values[i] = eigen.eigenvalues()[shape.size() - 1];
    agreement.push_back(mac(eigen.eigenvectors().col(shape.size() - 1), shape));
  }
  std::optional<Index> best;
  for (Index i = 1; i + 1 < range.count; ++i)
    if (values[i] >= values[i - 1] && values[i] > values[i + 1] &&
        agreement[static_cast<std::size_t>(i)] >= least_mac && (!best || values[i] > values[*best]))
      best = i;
  if (!best) return std::nullopt;
  const double left = std::log(values[*best - 1]), top = std::log(values[*best]), right = std::log(values[*best + 1]);
  const double curvature = left - 2.0 * top + right, off = curvature < 0.0 ? 0.5 * (left - right) / curvature : 0.0;
  return SpectralMode{(static_cast<double>(range.first + *best) + off) * spacing,
                      agreement[static_cast<std::size_t>(*best)]};
}

/// The same of modes whose spectra are of segments of one length.
void find_peaks(const Record& record, const VectorXd& scale, Index segment, const std::vector<IdentifiedMode>& modes,
                const std::vector<std::size_t>& chosen, std::vector<std::optional<SpectralMode>>& found) {
  WindowedTransform transform(segment);
  const Index length = transform(VectorXd::Zero(segment)).size();
  const double spacing = record.sample_rate / static_cast<double>(length);
  std::vector<LineRange> ranges;
  for (const std::size_t i : chosen) {
    const double reach = std::max(3.0 * half_power_bandwidth(modes[i]), 4.0 * spacing);
    const auto line = [&](double frequency) {
      return std::clamp<Index>(static_cast<Index>(std::lround(frequency / spacing)), 1, length / 2 - 1);
    };
    const Index first = line(modes[i].frequency - reach);
    ranges.push_back({first, line(modes[i].frequency + reach) - first + 1});
  }
  const auto spectra = cross_spectra(record, scale, segment, ranges, transform);
  for (std::size_t c = 0; c < chosen.size(); ++c)
    found[chosen[c]] =
        highest_peak(spectra[c], ranges[c], spacing, scale.cwiseInverse().cwiseProduct(modes[chosen[c]].shape));
}

}  // namespace

std::vector<std::optional<SpectralMode>> spectral_modes(const Record& record, const VectorXd& scale,
                                                        const std::vector<IdentifiedMode>& modes) {
  std::map<Index, std::vector<std::size_t>> by_segment;
  for (std::size_t i = 0; i < modes.size(); ++i) by_segment[segment_length(record, modes[i])].push_back(i);
  std::vector<std::optional<SpectralMode>> found(modes.size());
  for (const auto& [segment, chosen] : by_segment) find_peaks(record, scale, segment, modes, chosen, found);
  return found;
}

}  // namespace kalfem
