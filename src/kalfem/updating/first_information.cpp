// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/first_information.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/updating/modal_residual.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// By how much a parameter changes in one unit of ln theta.
Eigen::VectorXd relative_units(const std::vector<UpdatingParameter>& parameters) {
  Eigen::VectorXd units(std::ssize(parameters));
  for (Index i = 0; i < units.size(); ++i) units[i] = parameters[static_cast<std::size_t>(i)].scale();
  return units;
}

/// The first rows of a modal residual are (f - f_measured) / deviation, one a mode.
FrequencySensitivities of_frequencies(const ComparedResidual& comparison, const ModalResidual& modal,
                                      const MatrixXd& rows, const Eigen::VectorXd& values,
                                      const Eigen::VectorXd& units) {
  const auto modes = std::ssize(modal.measured());
  FrequencySensitivities result{comparison.name, Eigen::VectorXd(modes), rows.topRows(modes) * units.asDiagonal()};
  for (Index i = 0; i < modes; ++i) {
    const auto& mode = modal.measured()[static_cast<std::size_t>(i)];
    const double scale = mode.deviation / std::sqrt(comparison.weight);
    result.measured[i] = mode.frequency;
    result.relative.row(i) *= scale / (mode.frequency + scale * values[i]);
  }
  return result;
}

std::string joined(const std::vector<Index>& members, const std::vector<UpdatingParameter>& parameters) {
  std::string text;
  for (std::size_t i = 0; i < members.size(); ++i)
    text += (i == 0                    ? ""
             : i + 1 == members.size() ? " and "
                                       : ", ") +
            parameters[static_cast<std::size_t>(members[i])].name;
  return text;
}

bool have_one_value(const std::vector<Index>& members, const std::vector<UpdatingParameter>& parameters) {
  const auto value = [&](Index i) { return parameters[static_cast<std::size_t>(i)].initial; };
  return std::ranges::all_of(members, [&](Index i) { return value(i) == value(members.front()); });
}

}  // namespace

FirstInformation first_information(const std::vector<UpdatingParameter>& parameters, const ResidualValue& first,
                                   const std::vector<ComparedResidual>& comparisons) {
  FirstInformation found;
  const Eigen::VectorXd units = relative_units(parameters);
  Index row = 0;
  for (const auto& comparison : comparisons) {
    const Index size = comparison.residual->size();
    if (const auto* modal = dynamic_cast<const ModalResidual*>(comparison.residual.get());
        modal && comparison.weight > 0)
      found.frequencies.push_back(of_frequencies(comparison, *modal, first.jacobian.middleRows(row, size),
                                                 first.values.segment(row, size), units));
    row += size;
  }
  std::vector<InformedParameter> informed;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    informed.push_back({parameters[i].name, units[static_cast<Index>(i)], parameters[i].deviation});
  const MatrixXd information = first.jacobian.transpose() * first.jacobian;
  const IdentifiabilityOptions options{.data = "measurement"};
  found.told = identifiability(information, informed, options);
  for (const auto& combination : found.told.combinations)
    if (!combination.determined) found.remarks.push_back(combination.words);
  found.proposal = propose_groups(information, informed, options);
  return found;
}

std::vector<std::string> proposal_in_words(const std::vector<UpdatingParameter>& parameters,
                                           const ParameterGrouping& proposal) {
  std::vector<std::string> sentences;
  for (const auto& group : proposal.groups)
    if (group.size() > 1)
      sentences.push_back(have_one_value(group, parameters)
                              ? fmt::format("give {} one value", joined(group, parameters))
                              : fmt::format("change {} by one factor", joined(group, parameters)));
  if (!proposal.hold.empty()) sentences.push_back(fmt::format("hold {}", joined(proposal.hold, parameters)));
  return sentences;
}

}  // namespace kalfem
