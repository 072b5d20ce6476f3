// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "kalfem/model/lumped.hpp"
#include "kalfem/model/parameterised_model.hpp"

namespace kalfem::test {

/// Masses "floor1", "floor2", ... on springs and dashpots in series from the ground "base", with damping ratios. Any of
/// the values may be parameters.
class ChainModel final : public ParameterisedModel {
public:
  enum class Kind { stiffness, dashpot, mass, ratio };
  struct Parameter {
    Kind kind;
    std::vector<std::size_t> places;  ///< positions that have the value, from 0
  };

  std::vector<double> masses, stiffnesses, dashpots, ratios;
  double ratios_up_to = std::numeric_limits<double>::infinity();  ///< [Hz]
  std::vector<Parameter> parameters;

  [[nodiscard]] ModelAtParameters at(const Eigen::VectorXd& values) const override {
    const ChainModel chain = with(values);
    LumpedSubstructure lumped;
    lumped.grounds = {"base"};
    for (std::size_t i = 0; i < masses.size(); ++i) {
      const auto name = [](std::size_t floor) { return floor == 0 ? "base" : "floor" + std::to_string(floor); };
      lumped.masses.push_back({name(i + 1), chain.masses[i]});
      lumped.springs.push_back({"storey" + std::to_string(i + 1), name(i), name(i + 1), chain.stiffnesses[i],
                                chain.dashpots.empty() ? 0.0 : chain.dashpots[i]});
    }
    return {assemble(lumped), {chain.ratios, ratios_up_to}};
  }

  [[nodiscard]] std::vector<ModelDerivative> derivatives(const Eigen::VectorXd&) const override {
    std::vector<ModelDerivative> all;
    for (const auto& [kind, places] : parameters) {
      ModelDerivative& derivative = all.emplace_back();
      if (kind == Kind::ratio) {
        derivative.modal_ratios.assign(ratios.size(), 0.0);
        for (const auto i : places) derivative.modal_ratios[i] = 1.0;
        continue;
      }
      Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(Eigen::Index(masses.size()), Eigen::Index(masses.size()));
      for (const auto i : places) add(sum, kind, Eigen::Index(i));
      (kind == Kind::stiffness ? derivative.stiffness
       : kind == Kind::dashpot ? derivative.damping
                               : derivative.mass) = sum.sparseView();
    }
    return all;
  }

private:
  [[nodiscard]] ChainModel with(const Eigen::VectorXd& values) const {
    ChainModel chain = *this;
    for (std::size_t p = 0; p < parameters.size(); ++p)
      for (const auto i : parameters[p].places) {
        auto& list = parameters[p].kind == Kind::stiffness ? chain.stiffnesses
                     : parameters[p].kind == Kind::dashpot ? chain.dashpots
                     : parameters[p].kind == Kind::mass    ? chain.masses
                                                           : chain.ratios;
        list[i] = values[Eigen::Index(p)];
      }
    return chain;
  }

  static void add(Eigen::MatrixXd& sum, Kind kind, Eigen::Index i) {
    if (kind == Kind::mass) {
      sum(i, i) += 1.0;
      return;
    }
    Eigen::VectorXd elongation = Eigen::VectorXd::Zero(sum.rows());
    elongation[i] = 1.0;
    if (i > 0) elongation[i - 1] = -1.0;
    sum += elongation * elongation.transpose();
  }
};

}  // namespace kalfem::test
