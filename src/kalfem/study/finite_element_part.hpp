#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/assembly/fe_linear_model.hpp"
#include "kalfem/model/assembly/mass_properties.hpp"
#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

/// A finite-element substructure of a case: what it is made of, and its matrices.
struct FiniteElementPart {
  std::string name;
  FiniteElementModel elements;
  AssembledModel assembled;
  MassProperties mass;                                    ///< of the whole, also of what is held
  Eigen::Vector3d moving_mass = Eigen::Vector3d::Zero();  ///< that the free part moves along x, y, z [kg]
  std::vector<NamedNode> nodes;
  LinearModel full;
  std::vector<std::string> boundary;  ///< names of the degrees of freedom that the rest of the structure touches
  std::vector<DeckNote> notes;        ///< what its deck holds that was not used
  std::vector<std::string> warnings;  ///< on the boundary, in sentences
};
using FiniteElementPartPtr = std::shared_ptr<const FiniteElementPart>;

/// Reads the mesh, deck or matrices, assembles and damps them. `attached`: the points of it that connectors and forces
/// touch ("p1.z"). Throws InvalidInput with every problem and its place.
/// `parameters`: names of parameters that will change, without the substructure's own; those of beams are kept apart
/// only where they are named.
FiniteElementPart make_finite_element_part(const std::string& name, const description::Substructure& given,
                                           const std::vector<std::string>& attached,
                                           const std::vector<std::string>& parameters);

/// The superelement with modes as the case asks for; where it does not say, up to three times the sensors' bandwidth.
Superelement reduce(const FiniteElementPart& part, const std::optional<Located<description::Reduction>>& given,
                    double sensor_bandwidth);

/// The superelement of the part at other values of its parameters, with as many fixed-interface modes as `first` has,
/// in the order of its factor, and without the comparison with the full model.
Superelement reduce_again(const FiniteElementPart& part, const LinearModel& full,
                          const std::optional<Located<description::Reduction>>& given,
                          const ReductionErrorIndicators& first);

/// The superelement that stands for the full model up to a frequency.
Superelement reduce_up_to(const FiniteElementPart& part, double frequency);

}  // namespace kalfem
