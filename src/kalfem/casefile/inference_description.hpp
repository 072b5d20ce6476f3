// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/casefile/connector_description.hpp"
#include "kalfem/identification/inference_choices.hpp"
#include "kalfem/information/sensor_placement.hpp"
#include "kalfem/system/sensors/output_description.hpp"
#include "kalfem/yaml/schema.hpp"

/// What `kalfem infer` and `kalfem place` do, as the case file states it, see description.hpp.
namespace kalfem::description {

struct NormalPrior {
  Value mean;
  Value std;  ///< in the parameter's unit, or per cent of the mean
};
struct LogNormalPrior {
  Value median;
  double std = 0.5;  ///< of the natural logarithm
};
struct UniformPrior {
  std::array<Quantity, 2> between{};
};
/// The distribution of a parameter before the data.
struct Prior {
  std::variant<NormalPrior, LogNormalPrior, UniformPrior> shape;
  std::optional<std::array<Quantity, 2>> bounds;  ///< it is cut there
};

struct PriorCorrelation {
  std::array<Name, 2> between;
  double value = 0.0;
};

/// Another law for a connector, with its own unknown parameters.
struct LawAlternative {
  Connector connector;           ///< without its ends
  Named<Located<Prior>> priors;  ///< of its unknown parameters
};
struct LawComparison {
  std::vector<Name> connectors;  ///< each gets the law, with parameters of its own
  Named<Located<LawAlternative>> laws;
};

/// How much of the variance of some outputs each unknown makes under its prior.
struct Sensitivity {
  std::vector<Name> outputs;
  int samples = 256;  ///< N of N (unknowns + 2) model evaluations
};

struct Inference {
  std::vector<Name> parameters;  ///< of these; if empty, of all. The filter integrates the others out
  Named<Located<Prior>> priors;  ///< of unknowns; the others keep those of `estimate` or `update`
  std::vector<Located<PriorCorrelation>> correlations;
  std::optional<LikelihoodKind> likelihood;  ///< if empty: filter with `estimate`, otherwise comparisons
  double correlation_time = 0.0;             ///< of the model's error in a simulation [s]
  PosteriorMethod method = PosteriorMethod::importance;
  int samples = 1000;
  std::uint64_t seed = 1;
  int predictions = 40;  ///< draws of the posterior whose response is simulated for the predictive bands; 0: none
  std::vector<Name> profile;
  std::optional<Located<LawComparison>> laws;
  std::optional<Located<Sensitivity>> sensitivity;
};

/// Points at which a sensor could stand, one candidate each.
template <ObservedQuantity q>
struct CandidatePoints {
  static constexpr ObservedQuantity quantity = q;
  std::vector<Name> points;
};
struct CandidateGroup {
  std::variant<CandidatePoints<ObservedQuantity::acceleration>, CandidatePoints<ObservedQuantity::velocity>,
               CandidatePoints<ObservedQuantity::displacement>>
      observed;
  Value noise;            ///< a percentage of the channel's rms, or in the sensor's unit
  bool triaxial = false;  ///< the directions of a node are one sensor
  double spacing = 0.0;   ///< least distance between the nodes that a region gives [m]; 0: every one
};

struct Placement {
  Named<Located<CandidateGroup>> candidates;
  Located<int> count{1, {}, {}};
  std::vector<Name> parameters;  ///< that shall be known well; if empty, all unknowns
  std::vector<Name> keep;        ///< sensors of the case that stay
  PlacementCriterion criterion = PlacementCriterion::d_optimality;
  int draws = 1;  ///< parameter values from the priors over which it is averaged; 1: the initial values
  int largest_enumeration = 20000;  ///< sets up to which every one is tried
  std::uint64_t seed = 1;
};

}  // namespace kalfem::description
