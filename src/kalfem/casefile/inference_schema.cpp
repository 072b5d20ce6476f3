#include "kalfem/casefile/case_schema.hpp"
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

Schema<LawComparison> law_comparison() {
  const auto law =
      Fields<LawAlternative>()
          .required("law", &LawAlternative::law, name(), "name of the law; `kalfem schema --laws` lists them")
          .optional("parameters", &LawAlternative::parameters, named(value()), "parameters that are known")
          .optional("force", &LawAlternative::force, text(), "for law: expression: the force [N]")
          .required("priors", &LawAlternative::priors, named(located(prior())),
                    "unknown parameters of the law with their distributions before the data");
  return mapping(Fields<LawComparison>()
                     .required("connector", &LawComparison::connector, name(), "connector that each law is put into")
                     .required("laws", &LawComparison::laws, named(located(mapping(law))),
                               "the laws to choose from, by names of your own"));
}

template <class C>
Schema<C> candidate_points() {
  return convert<C>(
      one_or_list(name()), [](const std::vector<Name>& points) { return C{points}; },
      [](const C& given) { return given.points; });
}

Schema<CandidateGroup> candidate_group() {
  return mapping(
      Fields<CandidateGroup>()
          .one_of(&CandidateGroup::observed,
                  when("acceleration", candidate_points<AccelerationCandidates>(), "points; `all` for every one"),
                  when("velocity", candidate_points<VelocityCandidates>(), "points; `all` for every one"),
                  when("displacement", candidate_points<DisplacementCandidates>(), "points; `all` for every one"))
          .required("noise", &CandidateGroup::noise, value(),
                    "standard deviation of the noise: per cent of the channel's rms, or in the sensor's unit")
          .optional("triaxial", &CandidateGroup::triaxial, boolean(),
                    "the directions x, y, z of a node are one sensor with as many channels"));
}

}  // namespace

Schema<Inference> inference() {
  const auto correlation =
      Fields<PriorCorrelation>()
          .required("between", &PriorCorrelation::between, tuple<2>(name()), "two parameters")
          .required("value", &PriorCorrelation::value, number("-", Bounds::between(-0.999, 0.999)),
                    "correlation of the two as standard normal variables (Gaussian copula)");
  return mapping(
      Fields<Inference>()
          .optional("priors", &Inference::priors, named(located(prior()), NameRule::dotted),
                    "distributions of unknowns before the data; default: normal as `initial` and `std` say, log-normal "
                    "with transform: log, cut at `bounds`")
          .optional("correlations", &Inference::correlations, list(located(mapping(correlation))),
                    "priors that belong together")
          .optional("likelihood", &Inference::likelihood,
                    choice<std::optional<InferenceLikelihood>>(
                        {{"auto", std::nullopt, "filter where the case has `estimate`, otherwise comparisons"},
                         {"filter", InferenceLikelihood::filter,
                          "of the record by the filter: states and process noise are integrated out"},
                         {"simulation", InferenceLikelihood::simulation,
                          "of the record against the simulation under the known excitation"},
                         {"comparisons", InferenceLikelihood::comparisons, "of the comparisons of `update`"}}),
                    "how likely the data are at given parameters")
          .optional("correlation_time", &Inference::correlation_time, number("s", plausible::time()),
                    "for likelihood: simulation: correlation time of the difference that the model leaves; 0: white")
          .optional("method", &Inference::method,
                    choice<InferenceMethod>(
                        {{"tempered", InferenceMethod::tempered,
                          "transitional Markov chain Monte Carlo, with evidence; finds several modes"},
                         {"ensemble", InferenceMethod::ensemble, "affine-invariant ensemble sampler, without evidence"},
                         {"laplace", InferenceMethod::laplace,
                          "normal distribution about the most probable values, with evidence: the cheap first answer"}}),
                    "how the posterior is computed")
          .optional("samples", &Inference::samples, integer(50, 1000000), "samples of the posterior")
          .optional("seed", &Inference::seed, seed(), "seed of the samples")
          .optional("profile", &Inference::profile, one_or_list(name()),
                    "unknowns whose profile likelihood is computed: the best fit at each of their values")
          .optional("compare_laws", &Inference::laws, located(law_comparison()),
                    "laws for a connector, ranked by their evidence"));
}

Schema<Placement> placement() {
  return mapping(
      Fields<Placement>()
          .required("candidates", &Placement::candidates, named(located(candidate_group())),
                    "places where a sensor could stand, by names of your own")
          .required("count", &Placement::count, located(integer(1, 1000)), "number of sensors to place")
          .optional("parameters", &Placement::parameters, one_or_list(name()),
                    "unknowns that shall be known well; default: all of `estimate`")
          .optional("keep", &Placement::keep, one_or_list(name()), "sensors of the case that stay in any set")
          .optional("criterion", &Placement::criterion,
                    choice<PlacementCriterion>(
                        {{"determinant", PlacementCriterion::determinant, "smallest volume of the posterior (D)"},
                         {"trace", PlacementCriterion::trace, "smallest mean variance over the prior's (A)"},
                         {"smallest_eigenvalue", PlacementCriterion::smallest_eigenvalue,
                          "smallest deviation of the least known combination (E)"},
                         {"information", PlacementCriterion::information,
                          "largest mutual information of data and parameters"}}),
                    "what makes a set of sensors good")
          .optional("draws", &Placement::draws, integer(1, 1000),
                    "values of the unknowns, drawn from their priors, over which it is averaged; 1: the initial values")
          .optional("seed", &Placement::seed, seed(), "seed of these draws")
          .optional("largest_enumeration", &Placement::largest_enumeration, integer(1, 10000000),
                    "up to so many sets every one is tried; beyond, sensors are added and exchanged one by one"));
}

}  // namespace kalfem::description
