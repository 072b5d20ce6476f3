#include "kalfem/system/signals/spectral_lines.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "kalfem/system/option_checks.hpp"

namespace kalfem {

namespace {

constexpr Eigen::Index samples_per_block = 256;  // the table of 600 lines then fills 2.4 MB
constexpr Eigen::Index blocks_per_product = 64;  // bounds the memory of the coefficients

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
    const auto rows = std::min(samples_per_block, static_cast<Eigen::Index>(std::ceil(std::sqrt(double(count)))));
    const Eigen::MatrixXd table = block_table(step, rows);
    const Eigen::Index blocks = (count + rows - 1) / rows;
    for (Eigen::Index first = 0; first < blocks; first += blocks_per_product) {
      const Eigen::Index some = std::min(blocks_per_product, blocks - first);
      const Eigen::MatrixXd product = table * block_coefficients(start, step, rows, first, some);
      for (Eigen::Index b = 0; b < some; ++b) {
        const Eigen::Index row = (first + b) * rows;
        const Eigen::Index filled = std::min(rows, count - row);
        samples.middleRows(row, filled) = product.block(0, 3 * b, filled, 3).array();
      }
    }
    return samples;
  }

private:
  Eigen::Index size() const { return static_cast<Eigen::Index>(lines_.size()); }

  /// Row j: cos(w_l j step), sin(w_l j step) of all lines l; rows x 2 lines.
  Eigen::MatrixXd block_table(double step, Eigen::Index rows) const {
    Eigen::MatrixXd table(rows, 2 * size());
    for (Eigen::Index l = 0; l < size(); ++l)
      for (Eigen::Index j = 0; j < rows; ++j) {
        const double turned = angle(lines_[l].frequency, static_cast<double>(j) * step);
        table(j, l) = std::cos(turned);
        table(j, size() + l) = std::sin(turned);
      }
    return table;
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

}  // namespace kalfem
