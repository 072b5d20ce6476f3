// SPDX-License-Identifier: Apache-2.0
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/casefile/component_schema.hpp"
#include "kalfem/casefile/plausible.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::description {

using namespace schema;

namespace {

Schema<Prior> prior() {
  const auto normal = mapping(Fields<NormalPrior>()
                                  .required("mean", &NormalPrior::mean, value(), "mean")
                                  .required("std", &NormalPrior::std, value(),
                                            "standard deviation, in the parameter's unit or in per cent of the mean"));
  const auto lognormal =
      mapping(Fields<LogNormalPrior>()
                  .required("median", &LogNormalPrior::median, value(), "median, > 0")
                  .required("std", &LogNormalPrior::std, number("-", Bounds::positive()),
                            "standard deviation of the natural logarithm: 50 % is a factor of 1.65 either way"));
  const auto uniform = convert<UniformPrior>(
      tuple<2>(quantity()), [](const std::array<Quantity, 2>& between) { return UniformPrior{between}; },
      [](const UniformPrior& given) { return given.between; });
  return mapping(Fields<Prior>()
                     .one_of(&Prior::shape, when("normal", normal, "normal distribution"),
                             when("lognormal", lognormal, "log-normal distribution, of positive parameters"),
                             when("uniform", uniform, "the same density between two bounds"))
                     .optional("bounds", &Prior::bounds, tuple<2>(quantity()),
                               "lower and upper bound at which the distribution is cut"));
}

Schema<Sensitivity> sensitivity() {
  return mapping(Fields<Sensitivity>()
                     .required("outputs", &Sensitivity::outputs, one_or_list(name()),
                               "`frequency.N`: the N-th natural frequency of the whole structure; `force.CONNECTOR`: "
                               "largest force of a connector; `nis`: mean normalised innovation squared")
                     .optional("samples", &Sensitivity::samples, integer(16, 1000000),
                               "N of the N (unknowns + 2) evaluations; best a power of two"));
}

template <ObservedQuantity q>
Schema<CandidatePoints<q>> candidate_points() {
  return convert<CandidatePoints<q>>(
      one_or_list(name()), [](const std::vector<Name>& points) { return CandidatePoints<q>{points}; },
      [](const CandidatePoints<q>& given) { return given.points; });
}

Schema<CandidateGroup> candidate_group() {
  using enum ObservedQuantity;
  constexpr auto at =
      "points, or nodes for their motions along x, y and z; of finite elements also numbered nodes, frame.n12.z, and "
      "every node of a region, frame.rails.z; `all`: every point and every named node";
  return mapping(
      Fields<CandidateGroup>()
          .one_of(&CandidateGroup::observed, when("acceleration", candidate_points<acceleration>(), at),
                  when("velocity", candidate_points<velocity>(), at),
                  when("displacement", candidate_points<displacement>(), at))
          .required("noise", &CandidateGroup::noise, value(),
                    "standard deviation of the noise: per cent of the channel's rms, or in the sensor's unit")
          .optional("triaxial", &CandidateGroup::triaxial, boolean(),
                    "the directions x, y, z of a node are one sensor with as many channels")
          .optional("spacing", &CandidateGroup::spacing, number("m", Bounds::between(0.0, 1e9)),
                    "least distance between the nodes that a region gives; 0: every one"));
}

}  // namespace

Schema<LawComparison> law_comparison() {
  const auto law = Fields<LawAlternative>()
                       .inlined(&LawAlternative::connector, law_keys())
                       .required("priors", &LawAlternative::priors, named(located(prior())),
                                 "unknown parameters of the law with their distributions before the data");
  return mapping(Fields<LawComparison>()
                     .required("connector", &LawComparison::connectors, one_or_list(name()),
                               "connector that each law is put into; of several each has parameters of its own")
                     .required("laws", &LawComparison::laws, named(located(mapping(law))),
                               "the laws to choose from, by names of your own"));
}

Schema<Inference> inference() {
  const auto correlation = Fields<PriorCorrelation>()
                               .required("between", &PriorCorrelation::between, tuple<2>(name()), "two parameters")
                               .required("value", &PriorCorrelation::value, number("-", Bounds::between(-0.999, 0.999)),
                                         "correlation of the two as standard normal variables (Gaussian copula)");
  return mapping(
      Fields<Inference>()
          .optional("parameters", &Inference::parameters, one_or_list(name()),
                    "unknowns whose posterior is sought; default: all that are constant. The filter integrates the "
                    "others out, which costs less where there are many")
          .optional("priors", &Inference::priors, named(located(prior()), NameRule::dotted),
                    "distributions of unknowns before the data; default: normal as `initial` and `std` say, log-normal "
                    "with transform: log, cut at `bounds`")
          .optional("correlations", &Inference::correlations, list(located(mapping(correlation))),
                    "priors that belong together")
          .optional("likelihood", &Inference::likelihood,
                    choice<std::optional<LikelihoodKind>>(
                        {{"auto", std::nullopt, "filter where the case has `estimate`, otherwise comparisons"},
                         {"filter", LikelihoodKind::filter,
                          "of the record by the filter: states and process noise are integrated out"},
                         {"simulation", LikelihoodKind::simulation,
                          "of the record against the simulation under the known excitation"},
                         {"comparisons", LikelihoodKind::comparisons, "of the comparisons of `update`"}}),
                    "how likely the data are at given parameters")
          .optional("correlation_time", &Inference::correlation_time, number("s", plausible::time()),
                    "for likelihood: simulation: correlation time of the difference that the model leaves; 0: white")
          .optional("method", &Inference::method,
                    choice<PosteriorMethod>(
                        {{"importance", PosteriorMethod::importance,
                          "importance samples about the most probable values, with evidence: a thousand likelihoods, "
                          "where the posterior has one maximum"},
                         {"filter", PosteriorMethod::filter,
                          "normal distribution of the filter at the record's end, with evidence, all unknowns in its "
                          "state: one pass a law, within the filter's approximation"},
                         {"laplace", PosteriorMethod::laplace,
                          "normal distribution about the most probable values, with evidence: the cheap first answer"},
                         {"tempered", PosteriorMethod::tempered,
                          "transitional Markov chain Monte Carlo, with evidence; finds several maxima"},
                         {"metropolis", PosteriorMethod::metropolis,
                          "four adaptive Markov chains with diagnostics, without evidence"}}),
                    "how the posterior is computed")
          .optional("samples", &Inference::samples, integer(50, 1000000), "samples of the posterior")
          .optional("seed", &Inference::seed, seed(), "seed of the samples")
          .optional("predictions", &Inference::predictions, integer(0, 10000),
                    "draws of the posterior whose response is simulated, for predictive bands")
          .optional("profile", &Inference::profile, one_or_list(name()),
                    "unknowns whose profile likelihood is computed: the best fit at each of their values")
          .optional("compare_laws", &Inference::laws, located(law_comparison()),
                    "laws for a connector, ranked by their evidence")
          .optional("sensitivity", &Inference::sensitivity, located(sensitivity()),
                    "Sobol' indices: the share of each unknown in the variance that the priors give to an output"));
}

Schema<Placement> placement() {
  return mapping(
      Fields<Placement>()
          .required("candidates", &Placement::candidates, named(located(candidate_group())),
                    "places where a sensor could stand, by names of your own")
          .required("count", &Placement::count, located(integer(1, 1000)),
                    "number of sensors to place, beside those of `keep`")
          .optional(
              "parameters", &Placement::parameters, one_or_list(name()),
              "unknowns that shall be known well, while the others are unknown too; default: all of `estimate` that "
              "do not drift")
          .optional("keep", &Placement::keep, one_or_list(name()), "sensors of the case that stay in any set")
          .optional("criterion", &Placement::criterion,
                    choice<PlacementCriterion>(
                        {{"determinant", PlacementCriterion::d_optimality, "smallest volume of the posterior (D)"},
                         {"trace", PlacementCriterion::a_optimality, "smallest mean variance over the prior's (A)"},
                         {"smallest_eigenvalue", PlacementCriterion::e_optimality,
                          "smallest deviation of the least known combination (E)"},
                         {"deviation", PlacementCriterion::expected_deviation,
                          "smallest posterior deviation of `parameters`"},
                         {"information", PlacementCriterion::mutual_information,
                          "largest mutual information of data and parameters"}}),
                    "what makes a set of sensors good; parameters are scaled by their prior deviations")
          .optional("draws", &Placement::draws, integer(1, 1000),
                    "values of the unknowns, drawn from their priors, over which it is averaged; 1: the initial values")
          .optional("seed", &Placement::seed, seed(), "seed of these draws")
          .optional("largest_enumeration", &Placement::largest_enumeration, integer(1, 10000000),
                    "up to so many sets every one is tried; beyond, sensors are added and exchanged one by one"));
}

}  // namespace kalfem::description
