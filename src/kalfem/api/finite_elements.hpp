// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/gauges/gauge_description.hpp"
#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

/// A finite-element substructure as you describe it:
///     FiniteElements("frame", read_deck("frame.bdf").model).node("tip", 12).modal_damping({0.01}).reduce()
/// Names are looked up when the substructure is used. Its points are "frame.tip.x" and so on; its parameters
/// "frame.steel.youngs_modulus", "frame.skin.thickness", "frame.damping.modal".
class FiniteElements {
public:
  FiniteElements(std::string name, FiniteElementModel model);

  /// Names a node by the mesh's number of it.
  FiniteElements& node(const std::string& name, std::int64_t number);
  /// Names the node that is nearest to a place [m].
  FiniteElements& node(const std::string& name, const Eigen::Vector3d& place);
  /// Bonds a strain gauge to an element: gauge({.name = "g1", .place = Eigen::Vector3d(0.5, 0.0, 0.06), .direction =
  /// Eigen::Vector3d::UnitX(), .surface = Layer::top}). Its strain is strain("frame.g1").
  FiniteElements& gauge(GaugeDescription gauge);
  /// Holds all six motions of a named node.
  FiniteElements& fix(const std::string& node);
  /// Gives elements a factor of their stiffness or mass, the parameter "frame.west.factor". `elements`: names of sets,
  /// regions or materials, or numbers such as "101-250". Throws InvalidInput where one means no element, or the name is
  /// that of another factor. Factors of matrices: add_matrix_factor() of kalfem::formats.
  FiniteElements& factor(const std::string& name, const std::vector<std::string>& elements,
                         FactorOf of = FactorOf::stiffness, double value = 1.0);
  /// Damping ratios, one per mode; the last one applies to all further modes up to a frequency [Hz].
  FiniteElements& modal_damping(std::vector<double> ratios, double up_to);
  /// C = alpha M + beta K, alpha [1/s], beta [s].
  FiniteElements& rayleigh_damping(double alpha, double beta);
  /// Reduces the substructure: to the named nodes ("tip": its translations, "tip.rx") and to those that connectors and
  /// forces touch. Without it the full model is used.
  FiniteElements& reduce(ReductionRequest request = {}, std::vector<std::string> boundary = {});

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const FiniteElementModel& model() const { return model_; }

private:
  friend struct FiniteElementsAccess;

  struct NodePlace {
    std::string name;
    std::variant<std::int64_t, Eigen::Vector3d> where;
  };
  struct Damping {
    std::vector<double> ratios = {};
    double up_to = std::numeric_limits<double>::infinity();
    double alpha = 0.0, beta = 0.0;
  };

  std::string name_;
  FiniteElementModel model_;
  std::vector<NodePlace> nodes_;
  std::vector<GaugeDescription> gauges_;
  std::vector<std::string> fixed_, boundary_;
  Damping damping_;
  std::optional<ReductionRequest> reduction_;
  std::vector<std::pair<std::string, double>> numbers_;  ///< that Structure::at() set, by name: the last one counts
};

/// The superelement of a substructure that was told to reduce() itself, with its boundary; write_superelement() writes
/// it for other codes. Throws InvalidInput if a name or number does not exist, if the elements form a mechanism, or the
/// boundary is empty.
Superelement reduce(const FiniteElements& elements);

/// Lowest natural frequencies of the full model [Hz], ascending; rigid-body motions are 0. Throws InvalidInput as
/// above.
Eigen::VectorXd natural_frequencies(const FiniteElements& elements, Eigen::Index count);

}  // namespace kalfem
