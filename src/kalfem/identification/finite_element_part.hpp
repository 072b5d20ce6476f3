// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/phase_times.hpp"
#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/assembly/fe_linear_model.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/gauges/strain_gauge.hpp"
#include "kalfem/model/statics/load_case.hpp"
#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

/// A finite-element substructure at full order: its elements, damping and matrices. Immutable.
struct FiniteElementPart {
  std::string name;
  FiniteElementModel elements;
  AssembledModel assembled;  ///< without its terms where no parameter changes them: `full` has their sums
  MassProperties mass;       ///< with the fixed degrees of freedom
  Eigen::Vector3d moving_mass = Eigen::Vector3d::Zero();  ///< that the free part moves along x, y, z [kg]
  std::vector<NamedNode> nodes;
  std::map<std::string, std::vector<Eigen::Index>> load_groups = {};  ///< cells of the groups that loads name
  std::vector<LoadCase> deck_cases = {};                              ///< static load cases of its deck
  SparseMatrix preload_stiffness = {};                 ///< of stresses that it carries, 6 to a node; empty: none
  std::shared_ptr<const StiffnessFactor> factor = {};  ///< of `full`, where it is at hand
  LinearModel full;                                    ///< with its damping
  PhaseTimes times = {};                               ///< of its making: "read", "assemble", "factor"
  FiniteElementDamping damping;                        ///< included in `full`, with its dashpots
  std::vector<std::string> boundary;     ///< names of the degrees of freedom that the rest of the structure touches
  std::vector<StrainGauge> gauges = {};  ///< whose strains are gauges of `full`
};
using FiniteElementPartPtr = std::shared_ptr<const FiniteElementPart>;

/// Assembles what the part's `elements`, `preload_stiffness`, `nodes`, `gauges` and `damping` say: matrices, masses,
/// and the full model with Rayleigh damping and dashpots, without modal damping. Throws InvalidInput as assemble()
/// does, and where the elements do not hang together or are a mechanism, or the preload is beyond the buckling load.
void assemble_part(FiniteElementPart& part, AssemblyOptions options);

/// The assembled model with its terms, one each where no parameter changes them.
AssembledModel with_terms(const FiniteElementPart& part);

/// A finite-element substructure in the orders of model that are used beside each other.
struct FiniteElementSubstructure {
  FiniteElementPartPtr part;
  ReductionRequest reduction;
  std::shared_ptr<const Superelement> reduced;    ///< in the filter's model; empty if nothing is attached
  std::shared_ptr<const Superelement> reference;  ///< in the simulation; empty: the full model
};

/// The superelement of a part. `sensor_bandwidth` [Hz], infinite if no sensor has a limit. Of the full model at least
/// `full_modes` are computed for the comparison, for other uses.
Superelement reduce(const FiniteElementPart& part, const ReductionRequest& request, double sensor_bandwidth,
                    Eigen::Index full_modes = 0);

/// The lowest `count` modes of a finite-element substructure at full order: those of the comparison with its
/// superelement, where they are enough.
NormalModes lowest_full_modes(const FiniteElementSubstructure& substructure, Eigen::Index count);

/// The superelement of the part at other values of its parameters, with as many fixed-interface modes as `first` has,
/// in the order of its factor, and without the comparison with the full model.
Superelement reduce_again(const FiniteElementPart& part, const LinearModel& full, const ReductionRequest& request,
                          const ReductionErrorIndicators& first);

/// The superelement that stands for the full model up to a frequency [Hz].
Superelement reduce_up_to(const FiniteElementPart& part, double frequency);

}  // namespace kalfem
