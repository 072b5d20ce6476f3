// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/parameterised_model.hpp"

namespace kalfem {

/// A named place of a finite-element model.
struct NamedNode {
  std::string name;
  Eigen::Index node = 0;
  std::optional<double> distance = {};  ///< of the node from the place that the user gave, where one was given [m]
};

/// How a finite-element substructure is damped, beside its dashpots: C = C_dashpots + alpha M + beta K.
struct FeDamping {
  double mass_factor = 0.0;       ///< Rayleigh alpha [1/s]
  double stiffness_factor = 0.0;  ///< Rayleigh beta [s]
};

/// The assembled matrices as a LinearModel: degrees of freedom named "n<node id>.<direction>", each named node's six
/// motions as points "<name>.<direction>" through the expansion (a fixed one is left out). Rayleigh damping acts on the
/// motion relative to the shape in which the model follows slowly moving grounds, K s = k_g. Without modal damping.
/// Throws InvalidInput for factors that are negative, nodes that do not exist, and names given twice or that are taken
/// by another node.
LinearModel linear_model(const FiniteElementModel& model, const AssembledModel& assembled,
                         const std::vector<NamedNode>& points, const FeDamping& damping);
/// The same with K and M, the sums of the assembled terms, at hand.
LinearModel linear_model(const FiniteElementModel& model, const AssembledModel& assembled, SparseMatrix stiffness,
                         SparseMatrix mass, const std::vector<NamedNode>& points, const FeDamping& damping);

/// One number of a finite-element model that may be a parameter: one that its matrices are affine in, or of its
/// damping.
struct FiniteElementParameter {
  enum class Kind { matrix, modal_ratio, all_modal_ratios, mass_factor, stiffness_factor };
  Kind kind = Kind::matrix;
  std::string name;       ///< of Kind::matrix: "<material>.youngs_modulus", "<region>.thickness", ...
  std::size_t ratio = 0;  ///< of Kind::modal_ratio
};

/// Damping of a finite-element model beside its dashpots.
struct FiniteElementDamping {
  FeDamping rayleigh;
  ModalRatios modal_ratios = {};
};

/// Every parameter that the model has, under the names of LumpedParameter where it is the same thing.
std::vector<std::pair<std::string, FiniteElementParameter>> parameters_of(const AssembledModel& assembled,
                                                                          const FiniteElementDamping& damping);
std::string unit_of(const FiniteElementParameter& parameter);
double value_of(const AssembledModel& assembled, const FiniteElementDamping& damping,
                const FiniteElementParameter& parameter);

/// A finite-element model whose numbers follow theta: M and K are sums of matrices that were assembled once, times
/// products of powers of the parameters. Grounds stay as they are at the first values.
class ParameterisedFiniteElements final : public ParameterisedModel {
public:
  /// `full`: the model at the first values, with its names and points; `count`: length of theta. The assembled terms
  /// are needed only where a matrix or a Rayleigh factor follows theta.
  ParameterisedFiniteElements(std::shared_ptr<const AssembledModel> assembled, std::shared_ptr<const LinearModel> full,
                              FiniteElementDamping damping,
                              std::vector<ParameterBinding<FiniteElementParameter>> bindings, Eigen::Index count);

  [[nodiscard]] ModelAtParameters at(const Eigen::VectorXd& parameters) const override;
  [[nodiscard]] std::vector<ModelDerivative> derivatives(const Eigen::VectorXd& parameters) const override;
  /// The same function of theta in few coordinates, z = T q with T (n x r) the same for all theta: M_r(theta) =
  /// T^T M(theta) T, K_r and C_r alike. `reduced`: the model in q at `parameters`, without damping by modal ratios.
  [[nodiscard]] ParameterisedFiniteElements in_basis(const Eigen::MatrixXd& basis, const LinearModel& reduced,
                                                     const Eigen::VectorXd& parameters) const;

private:
  [[nodiscard]] std::map<std::string, double> values_at(const Eigen::VectorXd& parameters) const;
  [[nodiscard]] FiniteElementDamping damping_at(const Eigen::VectorXd& parameters) const;

  std::shared_ptr<const AssembledModel> assembled_;
  std::shared_ptr<const LinearModel> full_;
  FiniteElementDamping damping_;
  std::vector<ParameterBinding<FiniteElementParameter>> bindings_;
  Eigen::Index count_;
};

}  // namespace kalfem
