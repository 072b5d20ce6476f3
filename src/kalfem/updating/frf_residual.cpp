// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/frf_residual.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double least_coverage = 0.75;  ///< of the smoothing kernel by measured lines
constexpr double closest_lines = 0.5;    ///< of the smoothing width
constexpr double reduction = 3.0;        ///< from one smoothing width to the next

// From measured lines to residuals:
//   1. smoothed(): an FRF at i omega is compared at sigma + i omega, where Poisson's integral over the measured lines
//      gives it [Hof62]: resonances are wider there, so that a model far off still feels them. Lines nearer to each
//      other than half the width tell nothing new and are thinned.
//   2. deviations_of(): measured deviations, a relative part, and a floor where none were measured.
//   3. evaluate(): (H - H_m) / deviation, or |H_m| / deviation times ln(H / H_m), with derivatives from FrfModel.
//   4. take_out_scale(): a free factor of a set is its weighted mean log ratio, taken out of residuals and Jacobian.
bool in_bands(double line, const std::vector<FrequencyBand>& bands) {
  if (!(line > 0.0)) return false;
  return bands.empty() ||
         std::ranges::any_of(bands, [&](const FrequencyBand& band) { return line >= band.from && line <= band.to; });
}

/// Share of each line in Poisson's integral at frequency f: the kernel's exact integral over the line's cell, which
/// reaches halfway to its neighbours; `mirrored`: over the cell at the negative frequency.
VectorXd kernel_shares(const VectorXd& lines, double f, double width, bool mirrored) {
  const Index n = lines.size();
  VectorXd edges(n + 1);
  edges.segment(1, n - 1) = 0.5 * (lines.head(n - 1) + lines.tail(n - 1));
  edges[0] = std::max(0.0, lines[0] - 0.5 * (lines[1] - lines[0]));
  edges[n] = lines[n - 1] + 0.5 * (lines[n - 1] - lines[n - 2]);
  const double sign = mirrored ? -1.0 : 1.0;
  const VectorXd primitive = ((sign * edges.array() - f) / width).atan() / pi;
  return sign * (primitive.tail(n) - primitive.head(n));
}

/// One line of a smoothed FRF; nothing where too little of the kernel lies on measured lines.
struct SmoothedLine {
  VectorXcd values;
  VectorXd variances;
};

std::optional<SmoothedLine> smoothed_line(const FrequencyResponse& response, double f, double width) {
  const VectorXd shares = kernel_shares(response.lines, f, width, false);
  const VectorXd mirrored = kernel_shares(response.lines, f, width, true);
  const double coverage = shares.sum() + mirrored.sum();
  if (coverage < least_coverage) return std::nullopt;
  SmoothedLine line{(response.values.transpose() * shares + response.values.adjoint() * mirrored) / coverage, {}};
  if (response.deviations.size() > 0)
    line.variances = response.deviations.cwiseAbs2().transpose() * (shares.cwiseAbs2() + mirrored.cwiseAbs2()) /
                     (coverage * coverage);
  return line;
}

/// The lines that are used, as they were measured.
FrequencyResponse selected(const FrequencyResponse& response, const std::vector<FrequencyBand>& bands) {
  std::vector<Index> kept;
  for (Index k = 0; k < response.lines.size(); ++k)
    if (in_bands(response.lines[k], bands)) kept.push_back(k);
  FrequencyResponse selected{
      response.lines(kept), response.outputs, response.values(kept, Eigen::all), {}, response.magnitudes_only};
  if (response.deviations.size() > 0) selected.deviations = response.deviations(kept, Eigen::all);
  if (response.coherence.size() > 0) selected.coherence = response.coherence(kept, Eigen::all);
  return selected;
}

/// The lines that are used, smoothed and thinned.
FrequencyResponse smoothed(const FrequencyResponse& response, const FrfResidualOptions& options) {
  if (options.smoothing == 0.0 || response.lines.size() < 2) return selected(response, options.bands);
  std::vector<double> lines;
  std::vector<SmoothedLine> kept;
  for (const double f : response.lines) {
    if (!in_bands(f, options.bands)) continue;
    if (!lines.empty() && f - lines.back() < closest_lines * options.smoothing) continue;
    auto line = smoothed_line(response, f, options.smoothing);
    if (!line) continue;
    lines.push_back(f);
    kept.push_back(std::move(*line));
  }
  const auto rows = static_cast<Index>(lines.size());
  FrequencyResponse smoothed{Eigen::Map<const VectorXd>(lines.data(), rows),
                             response.outputs,
                             MatrixXcd(rows, response.values.cols()),
                             {},
                             false};
  if (response.deviations.size() > 0) smoothed.deviations.resize(rows, response.values.cols());
  for (Index k = 0; k < rows; ++k) {
    const SmoothedLine& line = kept[static_cast<std::size_t>(k)];
    smoothed.values.row(k) = line.values.transpose();
    if (response.deviations.size() > 0) smoothed.deviations.row(k) = line.variances.cwiseSqrt().transpose();
  }
  return smoothed;
}

/// Deviation of each value, from what is measured and what the options add.
MatrixXd deviations_of(const FrequencyResponse& response, const FrfResidualOptions& options) {
  const MatrixXd power = response.values.cwiseAbs2();
  MatrixXd squared = std::pow(options.relative_deviation, 2) * power;
  if (response.deviations.size() > 0)
    squared += response.deviations.cwiseAbs2();
  else
    squared.rowwise() += std::pow(options.floor, 2) * power.colwise().mean();
  return squared.cwiseSqrt();
}

/// Residuals of one value and their derivatives, as one complex number each.
struct ComplexResidual {
  Complex value;
  VectorXcd derivatives;
};

/// Columns of a set that share a free factor; none where the scale is fixed.
std::vector<std::vector<Index>> scaled_together(Index columns, FrfScale scale) {
  std::vector<std::vector<Index>> groups;
  for (Index j = 0; j < columns && scale != FrfScale::fixed; ++j) {
    if (scale == FrfScale::per_response || groups.empty()) groups.emplace_back();
    groups.back().push_back(j);
  }
  return groups;
}

/// Takes the best common factor of the model's responses in some columns out of their residuals, which begin at row
/// `first` with `parts` rows a value: r - w (w^T r) / (w^T w), and the same of the derivatives.
void take_out_scale(const FrequencyResponse& measured, const std::vector<Index>& columns, Index first, Index parts,
                    ResidualValue& residual) {
  std::vector<Index> rows;
  std::vector<double> weights;
  for (Index k = 0; k < measured.lines.size(); ++k)
    for (const Index j : columns) {
      rows.push_back(first + (k * measured.values.cols() + j) * parts);
      weights.push_back(std::abs(measured.values(k, j)) / measured.deviations(k, j));
    }
  const auto w = VectorXd::Map(weights.data(), static_cast<Index>(weights.size()));
  const VectorXd direction = w / w.squaredNorm();
  const double shift = direction.dot(residual.values(rows));
  residual.values(rows) -= shift * w;
  if (residual.jacobian.size() == 0) return;
  const Eigen::RowVectorXd shifts = direction.transpose() * residual.jacobian(rows, Eigen::all);
  residual.jacobian(rows, Eigen::all) -= w * shifts;
}

ComplexResidual compare(Complex model, const auto& derivatives, Complex measured, double deviation, FrfForm form) {
  if (form == FrfForm::complex_difference) return {(model - measured) / deviation, derivatives / deviation};
  const double weight = std::abs(measured) / deviation;
  return {weight * std::log(model / measured), (weight / model) * derivatives};
}

}  // namespace

FrfResidual::FrfResidual(std::shared_ptr<const ParameterisedModel> model, const std::vector<MeasuredFrf>& measured,
                         const VectorXd& start, FrfResidualOptions options)
    : options_(std::move(options)) {
  check_measured(measured, options_);
  std::vector<FrfSet> sets;
  double highest = 0.0;
  for (const auto& frf : measured) {
    FrequencyResponse& compared = compared_.emplace_back(smoothed(frf.response, options_));
    compared.deviations = deviations_of(compared, options_);
    if (compared.lines.size() > 0) highest = std::max(highest, compared.lines[compared.lines.size() - 1]);
    sets.push_back(frf.set);
    size_ += compared.values.size() * (options_.form == FrfForm::log_magnitude ? 1 : 2);
  }
  check_lines(measured, compared_, options_);
  model_.emplace(std::move(model), std::move(sets), highest, start, options_.basis);
  const FrfEvaluation evaluation = model_->evaluate(start, false);
  check_range(measured, compared_, evaluation.basis, options_.basis);
  if (options_.check_size) check_size(measured, compared_, model_responses(start), options_);
}

Complex FrfResidual::laplace_variable(double line) const { return 2.0 * pi * Complex(options_.smoothing, line); }

std::vector<MatrixXcd> FrfResidual::model_responses(const VectorXd& parameters) const {
  const FrfEvaluation evaluation = model_->evaluate(parameters, false);
  std::vector<MatrixXcd> responses;
  for (std::size_t i = 0; i < compared_.size(); ++i) {
    MatrixXcd& values = responses.emplace_back(compared_[i].values.rows(), compared_[i].values.cols());
    for (Index k = 0; k < values.rows(); ++k)
      values.row(k) = evaluation.at(i, laplace_variable(compared_[i].lines[k])).values.transpose();
  }
  return responses;
}

std::vector<VectorXd> FrfResidual::scales(const std::vector<MatrixXcd>& model) const {
  std::vector<VectorXd> all;
  for (std::size_t i = 0; i < compared_.size(); ++i) {
    const auto& measured = compared_[i];
    const MatrixXd weights = (measured.values.cwiseAbs().array() / measured.deviations.array()).square();
    const MatrixXd differences = (measured.values.cwiseAbs().array() / model[i].cwiseAbs().array()).log();
    VectorXd& scales = all.emplace_back(VectorXd::Ones(measured.values.cols()));
    for (const auto& columns : scaled_together(scales.size(), options_.scale)) {
      const MatrixXd w = weights(Eigen::all, columns), d = differences(Eigen::all, columns);
      scales(columns).setConstant(std::exp(w.cwiseProduct(d).sum() / w.sum()));
    }
  }
  return all;
}

std::optional<ResidualValue> FrfResidual::evaluate(const VectorXd& parameters, bool with_jacobian) const try {
  const FrfEvaluation evaluation = model_->evaluate(parameters, with_jacobian);
  ResidualValue residual{VectorXd(size_), {}};
  if (with_jacobian) residual.jacobian.resize(size_, parameters.size());
  Index row = 0;
  const auto add = [&](double value, const auto& derivatives) {
    residual.values[row] = value;
    if (with_jacobian) residual.jacobian.row(row) = derivatives.transpose();
    ++row;
  };
  for (std::size_t i = 0; i < compared_.size(); ++i) {
    const auto& [lines, outputs, values, deviations, magnitudes_only, coherence] = compared_[i];
    const Index first = row;
    for (Index k = 0; k < lines.size(); ++k) {
      const FrfLine line = evaluation.at(i, laplace_variable(lines[k]));
      for (Index j = 0; j < values.cols(); ++j) {
        const VectorXcd derivatives = with_jacobian ? VectorXcd(line.derivatives.row(j).transpose()) : VectorXcd();
        const auto difference = compare(line.values[j], derivatives, values(k, j), deviations(k, j), options_.form);
        add(difference.value.real(), difference.derivatives.real());
        if (options_.form != FrfForm::log_magnitude) add(difference.value.imag(), difference.derivatives.imag());
      }
    }
    for (const auto& columns : scaled_together(values.cols(), options_.scale))
      take_out_scale(compared_[i], columns, first, options_.form == FrfForm::log_magnitude ? 1 : 2, residual);
  }
  if (!residual.values.allFinite() || !residual.jacobian.allFinite()) return std::nullopt;
  return residual;
} catch (const InvalidInput&) {
  return std::nullopt;  // no structure, or none that holds itself
}

std::vector<ComparedGain> FrfResidual::gains() const {
  std::vector<ComparedGain> all;
  const auto add = [&](const ComparedGain& gain) {
    if (std::ranges::find(all, gain) == all.end()) all.push_back(gain);
  };
  for (const auto& set : sets())
    for (const auto& output : set.outputs) add({output + ".gain", false});
  for (const auto& set : sets()) add({"input." + set.place + ".gain", true});
  return all;
}

/// A measured response is a part of (output's gain) / (input's gain) larger than the true one.
std::optional<MatrixXd> FrfResidual::by_gains(const VectorXd& parameters) const try {
  const auto all = gains();
  const auto model = model_responses(parameters);
  ResidualValue by{VectorXd::Zero(size_), MatrixXd::Zero(size_, std::ssize(all))};
  const Index parts = options_.form == FrfForm::log_magnitude ? 1 : 2;
  Index row = 0;
  for (std::size_t i = 0; i < compared_.size(); ++i) {
    const auto& [values, deviations] = std::tie(compared_[i].values, compared_[i].deviations);
    const Index first = row,
                input = std::ranges::find(all, ComparedGain{"input." + sets()[i].place + ".gain", true}) - all.begin();
    for (Index k = 0; k < values.rows(); ++k)
      for (Index j = 0; j < values.cols(); ++j, row += parts) {
        const Index output =
            std::ranges::find(all, ComparedGain{sets()[i].outputs[static_cast<std::size_t>(j)] + ".gain", false}) -
            all.begin();
        const Complex change = options_.form == FrfForm::complex_difference
                                   ? -model[i](k, j) / deviations(k, j)
                                   : Complex(-std::abs(values(k, j)) / deviations(k, j));
        for (const auto& [column, sign] : {std::pair(output, 1.0), std::pair(input, -1.0)}) {
          by.jacobian(row, column) += sign * change.real();
          if (parts == 2) by.jacobian(row + 1, column) += sign * change.imag();
        }
      }
    for (const auto& columns : scaled_together(values.cols(), options_.scale))
      take_out_scale(compared_[i], columns, first, parts, by);
  }
  return by.jacobian;
} catch (const InvalidInput&) {
  return std::nullopt;
}

RowLayout FrfResidual::layout() const {
  std::vector<double> lines;
  for (const auto& compared : compared_) lines.insert(lines.end(), compared.lines.begin(), compared.lines.end());
  std::ranges::sort(lines);
  const auto repeated = std::ranges::unique(lines);
  lines.erase(repeated.begin(), repeated.end());
  RowLayout layout{.ordered = true, .steps = "frequency lines", .parts = compared_.size() > 1 ? "inputs" : "outputs"};
  const Index values = options_.form == FrfForm::log_magnitude ? 1 : 2;
  for (std::size_t i = 0; i < compared_.size(); ++i)
    for (const double line : compared_[i].lines)
      for (Index j = 0; j < values * compared_[i].values.cols(); ++j) {
        layout.step.push_back(std::ranges::lower_bound(lines, line) - lines.begin());
        layout.part.push_back(compared_.size() > 1 ? static_cast<Index>(i) : j / values);
      }
  return layout;
}

std::vector<double> smoothing_widths(double widest, double narrowest) {
  std::vector<double> widths;
  for (double width = widest; width >= narrowest * (1.0 - 1e-12) && width > 0.0; width /= reduction)
    widths.push_back(width);
  widths.push_back(0.0);
  return widths;
}

const FrfResidual* finest_responses(const std::vector<ResidualPtr>& continuation) {
  const FrfResidual* finest = nullptr;
  for (const auto& step : continuation)
    if (const auto* responses = dynamic_cast<const FrfResidual*>(step.get())) finest = responses;
  return finest;
}

}  // namespace kalfem
