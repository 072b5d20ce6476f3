// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/frf_estimates.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/segment_spectra.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// Below this part of its largest eigenvalue, the smallest one of S_ff in units of the inputs' powers is zero.
constexpr double dependent = 1e-8;

/// Sums over segments at one line.
struct LineSums {
  MatrixXcd inputs;  ///< S_ff
  MatrixXcd cross;   ///< S_yf, outputs x inputs
  VectorXd outputs;  ///< S_yy
};

void check(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs,
           const FrfEstimateOptions& options) {
  IssueList issues;
  if (inputs.empty()) issues.add({}, "no input is named", "responses are per force", "name the channels of the forces");
  if (outputs.empty()) issues.add({}, "no output is named", "there is no response", "name channels of motions");
  for (const auto& input : inputs)
    if (std::ranges::find(outputs, input) != outputs.end())
      issues.add({}, "'" + input + "' is an input and an output", "it cannot be both", "name it once");
  if (options.estimator == FrfEstimator::h2 && inputs.size() > 1)
    issues.add({}, "H2 of " + std::to_string(inputs.size()) + " inputs", "it is defined for one", "take H1 or Hv");
  issues.raise();
}

std::vector<LineSums> sums_of(std::span<const Record> records, const std::vector<std::string>& names, Index inputs,
                              const VectorXd& window, const H1Options& options) {
  const Index lines = (options.segment - 1) / 2, outputs = std::ssize(names) - inputs;
  std::vector<LineSums> sums(
      static_cast<std::size_t>(lines),
      {MatrixXcd::Zero(inputs, inputs), MatrixXcd::Zero(outputs, inputs), VectorXd::Zero(outputs)});
  for (const auto& record : records)
    for (Index i = 0; i < segments_in(record, options); ++i) {
      const MatrixXcd spectra = spectra_of(record, names, i * hop_of(options), window);
      for (Index k = 0; k < lines; ++k) {
        auto& [ff, yf, yy] = sums[static_cast<std::size_t>(k)];
        const VectorXcd f = spectra.row(k).head(inputs).transpose(), y = spectra.row(k).tail(outputs).transpose();
        ff += f * f.adjoint();
        yf += y * f.adjoint();
        yy += y.cwiseAbs2();
      }
    }
  return sums;
}

/// Whether the inputs are independent, each in units of its own power.
bool are_independent(const MatrixXcd& inputs) {
  const VectorXd power = inputs.diagonal().real();
  if (!(power.minCoeff() > 0.0)) return false;
  const VectorXd scale = power.cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXcd> eigen(MatrixXcd(scale.asDiagonal() * inputs * scale.asDiagonal()),
                                                       Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0] > dependent * eigen.eigenvalues().maxCoeff();
}

/// Total least squares of one output: the combination of [f; y] with the least power is w^H [f; y] = 0.
Eigen::RowVectorXcd total_least_squares(const LineSums& sums, Index output) {
  const Index inputs = sums.inputs.rows();
  MatrixXcd all(inputs + 1, inputs + 1);
  all.topLeftCorner(inputs, inputs) = sums.inputs;
  all.bottomLeftCorner(1, inputs) = sums.cross.row(output);
  all.topRightCorner(inputs, 1) = sums.cross.row(output).adjoint();
  all(inputs, inputs) = sums.outputs[output];
  if (!(sums.outputs[output] > 0.0)) return Eigen::RowVectorXcd::Zero(inputs);
  const VectorXd scale = all.diagonal().real().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXcd> eigen(MatrixXcd(scale.asDiagonal() * all * scale.asDiagonal()));
  const VectorXcd w = scale.cast<Complex>().cwiseProduct(eigen.eigenvectors().col(0));
  return -w.head(inputs).adjoint() / std::conj(w[inputs]);
}

MatrixXcd responses_of(const LineSums& sums, const MatrixXcd& inverse, FrfEstimator estimator) {
  if (estimator == FrfEstimator::h1) return sums.cross * inverse;
  MatrixXcd responses(sums.cross.rows(), sums.cross.cols());
  for (Index o = 0; o < responses.rows(); ++o)
    if (estimator == FrfEstimator::hv)
      responses.row(o) = total_least_squares(sums, o);
    else
      responses(o, 0) = std::abs(sums.cross(o, 0)) > 0.0 ? sums.outputs[o] / std::conj(sums.cross(o, 0)) : Complex(0.0);
  return responses;
}

}  // namespace

FrfMatrix estimate_frfs(std::span<const Record> records, const std::vector<std::string>& inputs,
                        const std::vector<std::string>& outputs, const FrfEstimateOptions& options) {
  check(inputs, outputs, options);
  std::vector<std::string> names = inputs;
  names.insert(names.end(), outputs.begin(), outputs.end());
  check_segments(records, names, options.spectra);
  const VectorXd window = window_of(options.spectra);
  const Index input_count = std::ssize(inputs);
  const double averages = effective_averages(records, window, options.spectra);
  if (averages < static_cast<double>(input_count))
    throw InvalidInput("the records hold " + std::to_string(static_cast<int>(averages)) + " segments",
                       std::to_string(input_count) + " inputs need as many independent ones and more",
                       "shorten the segments");
  const auto sums = sums_of(records, names, input_count, window, options.spectra);
  std::vector<Index> kept;
  for (Index k = 0; k < std::ssize(sums); ++k)
    if (are_independent(sums[static_cast<std::size_t>(k)].inputs)) kept.push_back(k);
  if (2 * kept.size() < sums.size())
    throw InvalidInput("the inputs are the same, or 0, at " + std::to_string(sums.size() - kept.size()) + " of " +
                           std::to_string(sums.size()) + " lines",
                       "their responses cannot be told apart", "name fewer inputs");
  const double spacing = records.front().sample_rate / static_cast<double>(options.spectra.segment);
  const bool known = averages > static_cast<double>(input_count) + 1e-9;
  FrfMatrix frfs{.lines = VectorXd(std::ssize(kept)), .outputs = {}, .inputs = inputs, .values = {}};
  frfs.values.assign(inputs.size(), MatrixXcd(std::ssize(kept), std::ssize(outputs)));
  if (known) frfs.deviations.assign(inputs.size(), MatrixXd(std::ssize(kept), std::ssize(outputs)));
  for (std::size_t row = 0; row < kept.size(); ++row) {
    const auto line = static_cast<Index>(row);
    const LineSums& at = sums[static_cast<std::size_t>(kept[row])];
    frfs.lines[line] = spacing * static_cast<double>(kept[row] + 1);
    const MatrixXcd inverse = at.inputs.inverse(), responses = responses_of(at, inverse, options.estimator);
    for (std::size_t i = 0; i < inputs.size(); ++i)
      frfs.values[i].row(line) = responses.col(static_cast<Index>(i)).transpose();
    if (!known) continue;
    const VectorXd coherent = (at.cross * inverse).cwiseProduct(at.cross.conjugate()).rowwise().sum().real();
    const VectorXd rest = (at.outputs - coherent).cwiseMax(0.0) / (2.0 * (averages - static_cast<double>(input_count)));
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      const auto at_input = static_cast<Index>(i);
      frfs.deviations[i].row(line) = (rest * inverse(at_input, at_input).real()).cwiseSqrt().transpose();
    }
  }
  const Record& first = records.front();
  for (const auto& name : outputs) frfs.outputs.push_back(first.channels[static_cast<std::size_t>(first.find(name))]);
  return frfs;
}

}  // namespace kalfem
