#pragma once

#include <limits>
#include <vector>

#include "kalfem/model/linear_model.hpp"

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

}  // namespace kalfem
