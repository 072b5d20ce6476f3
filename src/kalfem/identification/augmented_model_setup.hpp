#pragma once

#include <functional>
#include <map>
#include <optional>

#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/identification/parameterised_structure.hpp"

namespace kalfem {

/// Values that parameters have reached, by their names and by the names of all that they apply to.
using PresentValues = std::map<std::string, double>;

/// Unknowns of the filter on which the linear part of its model depends. Some are numbers of linear substructures that
/// no connector can carry. Others are carried by connectors, but the linear part's damping follows them: a released
/// spring of a substructure with modal damping.
struct LinearUnknowns {
  std::vector<std::string> names;          ///< one an unknown
  std::vector<double> initial;             ///< first guesses
  std::vector<StructureBinding> bindings;  ///< of those that no connector carries; the index is the place among all
  PresentValues present;                   ///< values that stood in for first guesses when the model was made
  std::shared_ptr<const StructureParts> parts;  ///< from which the model was made, before anything was released
  Eigen::VectorXd reduced_at;                   ///< values at which the finite elements are reduced
  /// The structure there: its bases serve for all values. Nothing where there are no bindings.
  std::shared_ptr<const StructureAtParameters> structure;

  [[nodiscard]] bool empty() const { return names.empty(); }
};

/// What the filter's model is made of: its own coupled model, which may be a part of the structure and holds the
/// guesses of unknowns in its linear part, and the sensors that it uses.
struct AugmentedModelSetup {
  std::shared_ptr<const CoupledModel> model;
  std::vector<Sensor> sensors;
  AugmentedModelOptions options;
  std::vector<std::string> input_sources;  ///< name of the excitation of each input, or of a sensor ("@name")
  std::vector<std::optional<double>> true_parameters;  ///< one an unknown
  LinearUnknowns linear_unknowns;
};

/// The filter's model of a problem, made of `parts`: the structure's own, or those that an updating has reached.
/// Values in `present` stand in for the first guesses of unknowns of the same name. Issues go to `issues` with their
/// place. `reduced_at`: values of the linear unknowns at which the finite elements are reduced, else the first guesses.
AugmentedModelSetup make_augmented_model_setup(const EstimationProblem& problem, StructureParts parts,
                                               const PresentValues& present, IssueList& issues,
                                               const std::optional<Eigen::VectorXd>& reduced_at = {});

/// The parts of a filter's model at values of its linear unknowns that no connector carries, in the bases of its
/// reduction.
StructureParts parts_at(const EstimationProblem& problem, const LinearUnknowns& unknowns,
                        const Eigen::VectorXd& values);

/// Sets the springs, dashpots and masses of a substructure that are unknowns of the filter to `values`, one an unknown
/// of the problem; of a structure whose modes are damped as a whole, every element and connector. Numbers in `refined`,
/// which an updating has set, are left as they are. Says whether any was set.
bool set_unknowns(const EstimationProblem& problem, const std::string& substructure, const Eigen::VectorXd& values,
                  const PresentValues& refined, StructureParts& parts);

/// The system of the filter's model as a function of its linear unknowns; nothing where it has none. It shares the
/// problem.
std::function<LocallyNonlinearSystem(const Eigen::VectorXd&)> system_of_linear_unknowns(
    const EstimationProblemPtr& problem, const AugmentedModelSetup& setup);

}  // namespace kalfem
