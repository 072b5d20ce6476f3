// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/assembly/fe_linear_model.hpp"
#include "kalfem/model/parameterised_model.hpp"

namespace kalfem::test {

/// K and M as sums of terms in products of parameters, some of which vary.
class AffineModel final : public ParameterisedModel {
public:
  AffineModel(LinearModel frame, std::vector<AffineTerm> stiffness, std::vector<AffineTerm> mass,
              std::vector<std::string> varied, std::map<std::string, double> values)
      : frame_(std::move(frame)),
        stiffness_(std::move(stiffness)),
        mass_(std::move(mass)),
        varied_(std::move(varied)),
        values_(std::move(values)) {}

  [[nodiscard]] ModelAtParameters at(const Eigen::VectorXd& parameters) const override {
    const auto values = values_at(parameters);
    LinearModel model = frame_;
    model.stiffness = evaluate(stiffness_, values);
    model.mass = evaluate(mass_, values);
    return {std::move(model), {}};
  }

  [[nodiscard]] std::vector<ModelDerivative> derivatives(const Eigen::VectorXd& parameters) const override {
    const auto values = values_at(parameters);
    std::vector<ModelDerivative> all;
    for (const auto& name : varied_)
      all.push_back({slope(stiffness_, name, values), slope(mass_, name, values), {}, {}});
    return all;
  }

  [[nodiscard]] Eigen::VectorXd start() const {
    Eigen::VectorXd start(static_cast<Eigen::Index>(varied_.size()));
    for (std::size_t i = 0; i < varied_.size(); ++i) start[static_cast<Eigen::Index>(i)] = values_.at(varied_[i]);
    return start;
  }

private:
  [[nodiscard]] std::map<std::string, double> values_at(const Eigen::VectorXd& parameters) const {
    auto values = values_;
    for (std::size_t i = 0; i < varied_.size(); ++i) values[varied_[i]] = parameters[static_cast<Eigen::Index>(i)];
    return values;
  }

  static SparseMatrix slope(const std::vector<AffineTerm>& terms, const std::string& name,
                            const std::map<std::string, double>& values) {
    SparseMatrix sum;
    for (const AffineTerm& term : terms) {
      const auto power = term.powers.find(name);
      if (power == term.powers.end() || power->second == 0) continue;
      AffineTerm lower = term;
      --lower.powers.at(name);
      const SparseMatrix part = power->second * affine_factor(lower, values) * term.matrix;
      sum = sum.rows() == 0 ? part : SparseMatrix(sum + part);
    }
    return sum;
  }

  LinearModel frame_;
  std::vector<AffineTerm> stiffness_, mass_;
  std::vector<std::string> varied_;
  std::map<std::string, double> values_;
};

/// A spring between two masses; -1 is the ground.
struct ChainSpring {
  int from = -1, to = 0;
  double stiffness = 1.0;
};

/// Masses "m0", "m1", ... on a line. Parameters: the stiffnesses of the springs, "k0", "k1", ..., all varied.
inline AffineModel spring_model(const std::vector<double>& masses, const std::vector<ChainSpring>& springs) {
  const auto n = static_cast<int>(masses.size());
  LinearModel frame;
  SparseMatrix mass(n, n);
  for (int i = 0; i < n; ++i) {
    frame.dofs.push_back("m" + std::to_string(i));
    mass.insert(i, i) = masses[static_cast<std::size_t>(i)];
  }
  std::vector<AffineTerm> terms;
  std::vector<std::string> names;
  std::map<std::string, double> values;
  for (const auto& spring : springs) {
    names.push_back("k" + std::to_string(names.size()));
    values[names.back()] = spring.stiffness;
    Eigen::VectorXd stretch = Eigen::VectorXd::Unit(n, spring.to);
    if (spring.from >= 0) stretch[spring.from] = -1.0;
    terms.push_back({{{names.back(), 1}}, SparseMatrix(Eigen::MatrixXd(stretch * stretch.transpose()).sparseView())});
  }
  return {frame, terms, {{{}, mass}}, names, values};
}

/// A finite-element model with some of its parameters varied; every node's motions are points "n<id>.<direction>".
inline AffineModel fe_affine_model(const FiniteElementModel& model, std::vector<std::string> varied) {
  const AssembledModel assembled = assemble(model);
  return {linear_model(model, assembled, {}, {}), assembled.stiffness, assembled.mass, std::move(varied),
          assembled.parameters};
}

inline std::shared_ptr<const AffineModel> shared(AffineModel model) {
  return std::make_shared<const AffineModel>(std::move(model));
}

/// Derivative of a function of one number by central differences, extrapolated once: exact to the fourth power of h.
template <typename Function>
auto slope_of(const Function& function, double at, double h) {
  const auto difference = [&](double step) {
    return ((function(at + step) - function(at - step)) / (2.0 * step)).eval();
  };
  return ((4.0 * difference(0.5 * h) - difference(h)) / 3.0).eval();
}

/// The same of a function of all parameters, by column; steps are relative.
inline Eigen::MatrixXd jacobian_by_differences(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& function,
                                               const Eigen::VectorXd& at, double step) {
  Eigen::MatrixXd jacobian(function(at).size(), at.size());
  for (Eigen::Index p = 0; p < at.size(); ++p)
    jacobian.col(p) = slope_of(
        [&](double value) {
          Eigen::VectorXd moved = at;
          moved[p] = value;
          return function(moved);
        },
        at[p], step * at[p]);
  return jacobian;
}

}  // namespace kalfem::test
