// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/model/linear_model.hpp"
#include "kalfem/model/lumped.hpp"

namespace kalfem {

/// Damping ratios of modes, to critical.
struct ModalRatios {
  std::vector<double> values = {};  ///< one a mode; the last holds for all further ones; empty: no such damping
  /// Modes above have the damping rate 2 zeta omega of the last one below, see add_modal_damping() [Hz]
  double up_to = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool empty() const { return values.empty(); }
};

/// A linear model at one value of its parameters. Damping by modal ratios is kept apart from the matrices, so that who
/// works in modes need not form it.
struct ModelAtParameters {
  LinearModel model;  ///< without damping by modal ratios
  ModalRatios modal_ratios;
};

/// Derivative of a model with respect to one parameter. A matrix that does not depend on it is 0 x 0.
struct ModelDerivative {
  SparseMatrix stiffness, mass, damping;  ///< n x n, symmetric
  std::vector<double> modal_ratios;       ///< one a ratio; empty where they do not depend on it

  [[nodiscard]] bool is_zero() const {
    return stiffness.nonZeros() == 0 && mass.nonZeros() == 0 && damping.nonZeros() == 0 && modal_ratios.empty();
  }
};

/// A linear substructure as a function of some of its parameters theta: M(theta) z'' + C(theta) z' + K(theta) z. Its
/// degrees of freedom and points do not depend on them. Immutable.
class ParameterisedModel {
public:
  virtual ~ParameterisedModel() = default;

  /// Throws InvalidInput where the values make no structure (a negative mass).
  [[nodiscard]] virtual ModelAtParameters at(const Eigen::VectorXd& parameters) const = 0;
  /// Exact derivatives at theta, one a parameter.
  [[nodiscard]] virtual std::vector<ModelDerivative> derivatives(const Eigen::VectorXd& parameters) const = 0;
};

/// One number of a lumped substructure that may be a parameter.
struct LumpedParameter {
  enum class Kind { stiffness, damping, mass, modal_ratio, all_modal_ratios, mass_factor, stiffness_factor };
  Kind kind = Kind::stiffness;
  std::size_t element = 0;  ///< index of the spring, mass or ratio
};

/// "<spring>.stiffness", "<spring>.damping", "<mass>.mass", "damping.modal" (all ratios as one), "damping.modal.<i>"
/// (the i-th given one), "damping.mass_factor", "damping.stiffness_factor".
std::vector<std::pair<std::string, LumpedParameter>> parameters_of(const LumpedSubstructure& substructure);

std::string unit_of(LumpedParameter::Kind kind);
double value_of(const LumpedSubstructure& substructure, const LumpedParameter& parameter);
void set_value(LumpedSubstructure& substructure, const LumpedParameter& parameter, double value);

/// theta[index] is the value of the target.
template <class Target>
struct ParameterBinding {
  Eigen::Index index = 0;
  Target target;
};

/// A lumped substructure whose numbers follow theta. Springs, dashpots and masses are in K, C and M linearly.
class ParameterisedLumped final : public ParameterisedModel {
public:
  /// `count`: length of theta, of which this substructure may use only a few entries.
  ParameterisedLumped(LumpedSubstructure substructure, std::vector<ParameterBinding<LumpedParameter>> bindings,
                      Eigen::Index count);

  [[nodiscard]] LumpedSubstructure substructure_at(const Eigen::VectorXd& parameters) const;
  [[nodiscard]] ModelAtParameters at(const Eigen::VectorXd& parameters) const override;
  [[nodiscard]] std::vector<ModelDerivative> derivatives(const Eigen::VectorXd& parameters) const override;

private:
  LumpedSubstructure substructure_;
  std::vector<ParameterBinding<LumpedParameter>> bindings_;
  Eigen::Index count_;
};

}  // namespace kalfem
