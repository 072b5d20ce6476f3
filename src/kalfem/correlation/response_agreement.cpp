// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/response_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "kalfem/updating/frf_residual.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXcd;
using Eigen::VectorXd;

bool ResponseAgreement::is_turned() const {
  constexpr double alike = 0.6, opposite = 150.0 / 180.0 * std::numbers::pi;
  return phase && frac >= alike && std::abs(*phase) > opposite;
}

ResponseAgreement agreement_of(std::string name, const VectorXcd& measured, const VectorXcd& model,
                               bool magnitudes_only) {
  ResponseAgreement agreement{.name = std::move(name)};
  const VectorXcd modelled = magnitudes_only ? VectorXcd(model.cwiseAbs().cast<std::complex<double>>()) : model;
  const double of_measured = measured.squaredNorm(), of_model = modelled.squaredNorm();
  if (of_measured == 0.0 || of_model == 0.0) return agreement;
  const std::complex<double> mixed = measured.dot(modelled);
  agreement.frac = std::norm(mixed) / (of_measured * of_model);
  agreement.size = std::sqrt(of_model / of_measured);
  if (!magnitudes_only) agreement.phase = std::arg(mixed);
  return agreement;
}

std::vector<ResponseAgreement> agreement_of(const FrfResidual& residual, const VectorXd& parameters) {
  std::vector<ResponseAgreement> all;
  const auto models = residual.model_responses(parameters);
  for (std::size_t i = 0; i < models.size(); ++i) {
    const auto& measured = residual.compared()[i];
    const auto& set = residual.sets()[i];
    for (Index j = 0; j < measured.values.cols(); ++j)
      all.push_back(agreement_of(set.outputs[static_cast<std::size_t>(j)] + per_input(set), measured.values.col(j),
                                 models[i].col(j), measured.magnitudes_only));
  }
  return all;
}

std::vector<std::string> turned_ones(const std::vector<ResponseAgreement>& responses) {
  const auto turned = std::ranges::count_if(responses, &ResponseAgreement::is_turned);
  if (turned == 0) return {};
  if (responses.size() > 1 && 2 * turned > std::ssize(responses))
    return {"the input is turned: " + std::to_string(turned) + " of " + std::to_string(responses.size()) +
            " responses agree with the model against its direction"};
  std::vector<std::string> sentences;
  for (const auto& each : responses)
    if (each.is_turned()) sentences.push_back(each.name + " is turned: it agrees with the model against its direction");
  return sentences;
}

}  // namespace kalfem
