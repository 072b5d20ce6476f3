// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>

#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/identification/parameterised_structure.hpp"

namespace kalfem {

/// Present values of parameters, by their names and by the names of all parameters that they apply to.
using PresentValues = std::map<std::string, double>;

/// Numbers of finite elements that are set beside the unknowns of the filter which these elements follow.
struct HeldElements {
  std::vector<Parameter> parameters = {};
  Eigen::VectorXd values = {};
  /// Whose bases serve, of the same parameters; null: the elements are reduced at these values.
  std::shared_ptr<const StructureAtParameters> structure = {};
};

/// Unknowns of the filter on which the linear part of its model depends. Some are parameters of linear substructures
/// that no connector can represent. Others are released into connectors, but the damping of the linear part depends on
/// them too: a released spring of a substructure with modal damping.
struct LinearUnknowns {
  std::vector<std::string> names;               ///< one per unknown
  std::vector<double> initial;                  ///< initial values
  std::vector<StructureBinding> bindings;       ///< of those without a connector; the index counts all unknowns
  PresentValues present;                        ///< values that replaced the initial ones when the model was made
  std::shared_ptr<const StructureParts> parts;  ///< from which the model was made, before anything was released
  Eigen::VectorXd reduced_at;                   ///< values at which the finite elements are reduced
  /// The structure at those values; its bases serve for all values. Empty without bindings.
  std::shared_ptr<const StructureAtParameters> structure;
  HeldElements held = {};

  [[nodiscard]] bool empty() const { return names.empty(); }
};

/// How finely a filter's model divides a sample interval, and what the division leaves in the estimates.
struct SubstepChoice {
  int substeps = 2;
  bool chosen = false;  ///< by the program, from the estimates; otherwise the caller gave it
  /// |bias| of each unknown's estimate that is left, in its standard deviations; empty: not measured.
  Eigen::VectorXd bias = {};
  bool limited = false;    ///< more are needed, but a limit was reached, or were not tried yet
  bool stopped = false;    ///< the search for more ended early, as second_thoughts allow no further run
  std::string words = {};  ///< how they were chosen

  /// The unknown with the largest bias; -1 where none was measured.
  [[nodiscard]] Eigen::Index largest() const;
};

/// Parts of the filter's model: its coupled model, which may be a part of the structure and holds initial values of
/// unknowns in its linear part, and the sensors that it uses.
struct AugmentedModelSetup {
  std::shared_ptr<const CoupledModel> model;
  std::vector<Sensor> sensors;
  AugmentedModelOptions options;
  std::vector<std::string> input_sources;  ///< name of the excitation of each input, or of a sensor ("@name")
  std::vector<std::optional<double>> true_parameters;  ///< one per unknown
  LinearUnknowns linear_unknowns;
  std::shared_ptr<const StructureParts> parts = {};  ///< from which it was made
  std::optional<SubstepChoice> substeps = {};        ///< decided before; otherwise the estimates decide
  std::optional<bool> starts_at_rest = {};  ///< decided before; otherwise the record tells, see make_filter_run()
};

/// Makes the filter's model of a problem from `parts`: the structure's own, or updated ones. Values in `present`
/// replace the initial values of unknowns with the same name. Issues go to `issues` with their place. `reduced_at`:
/// values of the linear unknowns at which the finite elements are reduced; by default the initial ones. `held`: counts
/// where finite elements follow unknowns.
AugmentedModelSetup make_augmented_model_setup(const EstimationProblem& problem, StructureParts parts,
                                               const PresentValues& present, IssueList& issues,
                                               const std::optional<Eigen::VectorXd>& reduced_at = {},
                                               const HeldElements& held = {});

/// The parts of a filter's model at other values of its linear unknowns, in the bases of its reduction.
StructureParts parts_at(const EstimationProblem& problem, const LinearUnknowns& unknowns,
                        const Eigen::VectorXd& values);

/// Sets the springs, dashpots and masses of a substructure that are unknowns of the filter to `values`, one per unknown
/// of the problem. With modal damping of the whole structure, sets every element and connector. Parameters in
/// `refined`, set by an updating, keep their values. Returns whether any was set.
bool set_unknowns(const EstimationProblem& problem, const std::string& substructure, const Eigen::VectorXd& values,
                  const PresentValues& refined, StructureParts& parts);

/// The system of the filter's model as a function of its linear unknowns; empty if it has none. It shares the problem.
std::function<LocallyNonlinearSystem(const Eigen::VectorXd&)> system_of_linear_unknowns(
    const EstimationProblemPtr& problem, const AugmentedModelSetup& setup);

}  // namespace kalfem
