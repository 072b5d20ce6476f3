// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/frf_record_residual.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/updating/frf_leakage.hpp"

namespace kalfem {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double least_deviation = 1e-6;  ///< of the rms of an output's lines: rounding of a simulated record

bool in_bands(double line, const std::vector<FrequencyBand>& bands) {
  return bands.empty() ||
         std::ranges::any_of(bands, [&](const FrequencyBand& band) { return line >= band.from && line <= band.to; });
}

/// From the lowest to the highest limit.
FrequencyBand hull_of(const std::vector<FrequencyBand>& bands) {
  if (bands.empty()) return {0.0, std::numeric_limits<double>::infinity()};
  return {std::ranges::min_element(bands, {}, &FrequencyBand::from)->from,
          std::ranges::max_element(bands, {}, &FrequencyBand::to)->to};
}

ComparedSpectra compared_of(const FrfRecord& record, const FrfResidualOptions& options) {
  const RecordSpectra& spectra = record.spectra;
  std::vector<Index> kept;
  for (Index k = 0; k < spectra.lines.size(); ++k)
    if (in_bands(spectra.lines[k], options.bands)) kept.push_back(k);
  if (kept.empty())
    throw InvalidInput("FRF '" + record.name + "' has no line in the bands", "a line is the inverse of the duration",
                       "change the bands");
  ComparedSpectra compared{.lines = spectra.lines(kept),
                           .input = spectra.input(kept),
                           .outputs = spectra.outputs(kept, Eigen::all),
                           .deviations = (0.5 * record.fit.noise(kept, Eigen::all)).cwiseSqrt(),
                           .edges = spectra.edges,
                           .sample_rate = spectra.sample_rate};
  const MatrixXd relative = options.relative_deviation * compared.outputs.cwiseAbs();
  compared.deviations = (compared.deviations.cwiseAbs2() + relative.cwiseAbs2()).cwiseSqrt();
  for (Index j = 0; j < compared.outputs.cols(); ++j) {
    const double size = std::sqrt(compared.outputs.col(j).cwiseAbs2().mean());
    if (!(size > 0.0))
      throw InvalidInput("FRF '" + record.name + "': channel " + std::to_string(j + 1) + " is zero in the bands", "",
                         "leave it out");
    compared.deviations.col(j) = compared.deviations.col(j).cwiseMax(least_deviation * size);
  }
  return compared;
}

/// Puts lines x outputs over sigma into rows of lines, outputs, Re and Im.
void put_rows(const MatrixXcd& values, const MatrixXd& deviations, Eigen::Ref<VectorXd> rows) {
  for (Index k = 0, row = 0; k < values.rows(); ++k)
    for (Index j = 0; j < values.cols(); ++j, row += 2) {
      rows[row] = values(k, j).real() / deviations(k, j);
      rows[row + 1] = values(k, j).imag() / deviations(k, j);
    }
}

/// dH U + dT at the amplitudes, rows x parameters.
MatrixXd derivatives_of(const FrfEvaluation& evaluation, std::size_t set, const ComparedSpectra& spectra,
                        const LeakageColumns& leakage, const VectorXd& amplitudes) {
  const auto parameters = std::ssize(evaluation.derivatives);
  const VectorXd factors = leakage.factors(amplitudes);
  const bool scaled = (factors.array() != 1.0).any();
  MatrixXd jacobian(2 * spectra.outputs.size(), parameters);
  for (Index k = 0, row = 0; k < spectra.lines.size(); ++k) {
    const Complex s(0.0, 2.0 * std::numbers::pi * spectra.lines[k]);
    const auto free = leakage.load(amplitudes, s);
    const Complex input = spectra.input[k] * leakage.input_factor(amplitudes, spectra.lines[k]);
    MatrixXcd line = evaluation.derivatives_under(set, s, input, free);
    if (scaled)
      line += (factors.array() - 1.0).matrix().asDiagonal() *
              evaluation.derivatives_under(set, s, input, Eigen::VectorXcd::Zero(free.size()));
    for (Index j = 0; j < line.rows(); ++j, row += 2) {
      jacobian.row(row) = line.row(j).real() / spectra.deviations(k, j);
      jacobian.row(row + 1) = line.row(j).imag() / spectra.deviations(k, j);
    }
  }
  return jacobian;
}

}  // namespace

FrfRecord frf_record(std::string name, const Record& record, const std::string& input,
                     const std::vector<std::string>& outputs, FrfSet set, const std::vector<FrequencyBand>& bands) {
  RecordSpectra spectra = record_spectra(record, input, outputs);
  const FrequencyBand band = hull_of(bands);
  LocalRationalFit fit = fit_local_rational(spectra, band);
  const Index first = std::ranges::lower_bound(spectra.lines, band.from) - spectra.lines.begin();
  const Index count = fit.noise.rows();
  spectra.lines = spectra.lines.segment(first, count).eval();
  spectra.input = spectra.input.segment(first, count).eval();
  spectra.outputs = spectra.outputs.middleRows(first, count).eval();
  return {std::move(name), std::move(spectra), std::move(fit), std::move(set)};
}

std::vector<MeasuredFrf> local_rational_responses(const std::vector<FrfRecord>& records) {
  std::vector<MeasuredFrf> responses;
  for (const auto& record : records) responses.push_back({record.name, record.fit.response, record.set});
  return responses;
}

FrfRecordResidual::FrfRecordResidual(std::shared_ptr<const ParameterisedModel> model,
                                     const std::vector<FrfRecord>& records, const VectorXd& start,
                                     const FrfResidualOptions& options)
    : scale_(options.scale) {
  std::vector<FrfSet> sets;
  double highest = 0.0;
  for (const auto& record : records) {
    const ComparedSpectra& compared = compared_.emplace_back(compared_of(record, options));
    highest = std::max(highest, compared.lines.tail(1)[0]);
    size_ += 2 * compared.outputs.size();
    sets.push_back(record.set);
  }
  model_.emplace(std::move(model), std::move(sets), highest, start, options.basis);
}

// For each record: the forced part H U and the columns of the leakage; the residual, whitened by their prior; its
// derivatives with the leakage at its best amplitudes, whitened by the same.
std::optional<ResidualValue> FrfRecordResidual::evaluate(const VectorXd& parameters, bool with_jacobian) const try {
  const FrfEvaluation evaluation = model_->evaluate(parameters, with_jacobian);
  ResidualValue residual{VectorXd(size_), {}};
  if (with_jacobian) residual.jacobian.resize(size_, parameters.size());
  Index first = 0;
  for (std::size_t i = 0; i < compared_.size(); ++i) {
    const ComparedSpectra& spectra = compared_[i];
    const Index rows = 2 * spectra.outputs.size();
    const LeakageColumns leakage(evaluation, i, spectra, scale_);
    if (!leakage.columns().allFinite()) return std::nullopt;
    const LeakageProjection projection(leakage.columns());
    VectorXd difference(rows);
    put_rows(leakage.forced() - spectra.outputs, spectra.deviations, difference);
    residual.values.segment(first, rows) = projection.whitened(difference);
    if (with_jacobian)
      residual.jacobian.middleRows(first, rows) =
          projection.whitened(derivatives_of(evaluation, i, spectra, leakage, projection.amplitudes(difference)));
    first += rows;
  }
  if (!residual.values.allFinite() || !residual.jacobian.allFinite()) return std::nullopt;
  return residual;
} catch (const InvalidInput&) {
  return std::nullopt;  // no structure, or none that holds itself
}

RowLayout FrfRecordResidual::layout() const {
  std::vector<double> lines;
  for (const auto& compared : compared_) lines.insert(lines.end(), compared.lines.begin(), compared.lines.end());
  std::ranges::sort(lines);
  const auto repeated = std::ranges::unique(lines);
  lines.erase(repeated.begin(), repeated.end());
  RowLayout layout{.ordered = true, .steps = "frequency lines", .parts = compared_.size() > 1 ? "records" : "outputs"};
  for (std::size_t i = 0; i < compared_.size(); ++i)
    for (const double line : compared_[i].lines)
      for (Index value = 0; value < 2 * compared_[i].outputs.cols(); ++value) {
        layout.step.push_back(std::ranges::lower_bound(lines, line) - lines.begin());
        layout.part.push_back(compared_.size() > 1 ? static_cast<Index>(i) : value / 2);
      }
  return layout;
}

}  // namespace kalfem
