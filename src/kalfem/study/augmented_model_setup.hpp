#pragma once

#include <functional>
#include <optional>

#include "kalfem/study/unknown_builder.hpp"

namespace kalfem {

PresentValues present_values(const UpdatingSetup& updating, const Eigen::VectorXd& values);

/// The augmented model of the case's `estimate`, made of `parts`: the case's own, or those that an updating has
/// reached. Values in `present` stand in for the first guesses of unknowns of the same name. Problems go to `issues`
/// with their place. `reduced_at`: values of the linear unknowns at which the finite elements are reduced, else the
/// first guesses.
AugmentedModelSetup make_augmented_model_setup(const Study& study, StructureParts parts, const PresentValues& present,
                                               IssueList& issues,
                                               const std::optional<Eigen::VectorXd>& reduced_at = {});

/// The parts of an augmented model at values of its linear unknowns that no connector carries, in the bases of its
/// reduction.
StructureParts parts_at(const Study& study, const LinearUnknowns& unknowns, const Eigen::VectorXd& values);

/// Sets the springs, dashpots and masses of a substructure that are unknowns of the filter to `values`, one an unknown
/// of the case; of a structure whose modes are damped as a whole, every element and connector. Numbers in `refined`,
/// which an updating has set, are left as they are. Says whether any was set.
bool set_unknowns(const Study& study, const std::string& substructure, const Eigen::VectorXd& values,
                  const PresentValues& refined, StructureParts& parts);

/// The augmented model's system as a function of its linear unknowns; nothing where it has none. The case must outlive
/// it.
std::function<LocallyNonlinearSystem(const Eigen::VectorXd&)> system_of_linear_unknowns(
    const Study& study, const AugmentedModelSetup& setup);

}  // namespace kalfem
