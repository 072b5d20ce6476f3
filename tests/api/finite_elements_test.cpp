// SPDX-License-Identifier: Apache-2.0
#include "cantilever.hpp"

namespace kalfem {
namespace {

using testing::Contains;
using testing::HasSubstr;

TEST(FiniteElementParts, HaveTheFrequenciesOfTheClosedForm) {
  const auto frequencies = natural_frequencies(cantilever(), 2);
  EXPECT_NEAR(frequencies[0], first_frequency(), 1e-3 * first_frequency());
  EXPECT_NEAR(frequencies[1], 2.0 * first_frequency(), 2e-3 * first_frequency());  // the other side is twice as thick
}

TEST(FiniteElementParts, AreReducedToTheNodesThatAreKept) {
  const Superelement reduced = reduce(cantilever().reduce({.modes = {.count = 6}}, {"tip"}));
  EXPECT_EQ(reduced.boundary.size(), 3u);
  EXPECT_EQ(reduced.model.dofs[0], "n11.x");
  EXPECT_LT(reduced.model.size(), 20);
  const auto modes = normal_modes(reduced.model.mass, reduced.model.stiffness);
  EXPECT_NEAR(modes.frequencies[0], first_frequency(), 2e-3 * first_frequency());
}

TEST(FiniteElementParts, CarryConnectorsAndUnknowns) {
  Structure s;
  s.add(cantilever().modal_damping({0.01}, 500.0).reduce({.modes = {.count = 4}}));
  s.connect("stop", "beam.tip.z", "ground", law("polynomial", {{"k1", 1e3}, {"k3", 1e9}}));
  Eigen::VectorXd push(501);
  for (Eigen::Index k = 0; k < push.size(); ++k) push[k] = 5.0 * std::sin(0.1 * static_cast<double>(k));
  s.force("push", "beam.tip.z", {push, 500.0});
  EXPECT_THAT(s.parameters(), Contains("beam.steel.youngs_modulus"));
  EXPECT_THAT(s.points(), Contains("beam.tip.z"));
  const std::vector<SensorDescription> sensors = {{"tip", acceleration("beam.tip.z"), 0.05}};
  const auto record = simulate(s, {.sensors = sensors, .duration = 1.0, .sample_rate = 500.0, .seed = 1}).record;
  const auto result = estimate(s, record,
                               {.sensors = sensors,
                                .unknowns = {{"stop.k3", {.initial = 6e8, .std = 4e8}},
                                             {"beam.steel.youngs_modulus", {.initial = 200e9, .std = 15e9}}}});
  ASSERT_TRUE(result.usable());
  EXPECT_NEAR(result.parameters[0].mean, 1e9, 3.0 * result.parameters[0].std);
  EXPECT_NEAR(result.parameters[1].mean, 210e9, 1e-3 * 210e9);  // the record is of the full model, not of four modes
  EXPECT_LT(result.parameters[1].std, 1e-3 * 210e9);
}

/// Beside an unknown modulus the density and the damping are varied too: a beam 1 % heavier than stated is told, and
/// the modulus follows the density as in whole estimations beside it.
TEST(FiniteElementParts, AreVariedBesideTheirUnknowns) {
  const auto beam = [](double density) {
    Structure s;
    s.add(cantilever().modal_damping({0.01}, 500.0).reduce({.modes = {.count = 4}}));
    Eigen::VectorXd push(501);
    for (Eigen::Index k = 0; k < push.size(); ++k) push[k] = 5.0 * std::sin(0.1 * static_cast<double>(k));
    s.force("push", "beam.tip.z", {push, 500.0});
    return s.at({{"beam.steel.density", density * s.value("beam.steel.density")}});
  };
  const std::vector<SensorDescription> sensors = {{"tip", acceleration("beam.tip.z"), 0.05}};
  const auto record =
      simulate(beam(1.01), {.sensors = sensors, .duration = 0.6, .sample_rate = 500.0, .seed = 1}).record;
  const auto estimated = [&](double density, bool diagnose) {
    return estimate(beam(density), record,
                    {.sensors = sensors,
                     .unknowns = {{"beam.steel.youngs_modulus", {.initial = 205e9, .std = 15e9}}},
                     .substeps = 2,
                     .diagnose = diagnose,
                     .free = FreeNumbers::none});
  };
  const auto found = estimated(1.0, true);
  const auto number = [&](const std::string& name) {
    return std::ranges::find(found.fixed_numbers, name, &FixedNumberEffect::name);
  };
  const auto density = number("beam.steel.density");
  ASSERT_NE(density, found.fixed_numbers.end());
  EXPECT_NE(number("beam.damping.modal.1"), found.fixed_numbers.end());
  EXPECT_NEAR(density->asked, 0.01, 0.004);  // four modes of it ask for a part
  constexpr double h = 2e-3;
  const auto modulus = [&](double factor) { return estimated(factor, false).parameters[0].mean; };
  const double shift = (modulus(1.0 + h) - modulus(1.0 - h)) / (2.0 * h);
  EXPECT_NEAR(density->shift[0], shift, 0.05 * std::abs(shift));
}

/// Without mass at its rotations a beam would stand as if these were held, 20 times too stiff.
TEST(FiniteElementParts, AreNotSimulatedWithoutMass) {
  const auto pushed = [](MassKind kind) {
    FiniteElementModel model = cantilever().model();
    model.mass_kind = kind;
    std::get<BeamProperty>(model.properties.at("bar")).lumped_inertia = LumpedInertia::none;
    Structure s;
    s.add(FiniteElements("beam", model).node("root", 1).node("tip", 11).fix("root"));
    s.force("push", "beam.tip.z", {Eigen::VectorXd::Constant(101, 1.0), 500.0});
    const auto data = simulate(s, {.sensors = {{"tip", displacement("beam.tip.z"), 1e-9}}, .duration = 0.2});
    return data.record.values.row(0).mean();
  };
  const double inertia = 0.02 * std::pow(0.01, 3) / 12.0, bent = 1.0 / (3.0 * 210e9 * inertia);  // of 1 m
  EXPECT_NEAR(pushed(MassKind::consistent), bent, 0.1 * bent);  // it swings about its static deflection
  EXPECT_THAT(refusal_of([&] { pushed(MassKind::lumped); }), HasSubstr("have no mass"));
}

// A unit force bends the cantilever: epsilon = -z F (L - x) / E I, at the middle of the third element.
TEST(FiniteElementParts, CarryStrainGauges) {
  const auto with_gauge = [](std::int64_t element) {
    return cantilever().gauge({.name = "g", .place = element, .fibre = Eigen::Vector2d(0.0, 5e-3)}).reduce({}, {"tip"});
  };
  const auto model = reduce(with_gauge(3)).model;
  const Eigen::VectorXd bent = Eigen::MatrixXd(model.stiffness).ldlt().solve(Eigen::VectorXd::Unit(model.size(), 2));
  double strain = 0.0;
  for (Eigen::Index i = 0; i < model.size(); ++i)
    if (const auto own = model.gauges.at("g").find(model.dofs[static_cast<std::size_t>(i)]);
        own != model.gauges.at("g").end())
      strain += own->second * bent[i];
  const double inertia = 0.02 * std::pow(0.01, 3) / 12.0, expected = -5e-3 * 0.75 / (210e9 * inertia);
  EXPECT_NEAR(strain, expected, 1e-6 * std::abs(expected));
  EXPECT_THAT(refusal_of([&] { reduce(with_gauge(30)); }), HasSubstr("strain gauge 'g' stands on element 30"));
}

/// H(0) of the strain per force at the tip, full and reduced, is that of the bent cantilever above.
TEST(FiniteElementParts, HaveFrequencyResponsesOfStrain) {
  const double inertia = 0.02 * std::pow(0.01, 3) / 12.0, expected = -5e-3 * 0.75 / (210e9 * inertia);
  const auto gauged = cantilever().gauge({.name = "g", .place = std::int64_t{3}, .fibre = Eigen::Vector2d(0.0, 5e-3)});
  for (FiniteElements elements : {gauged, FiniteElements(gauged).reduce({}, {"tip"})}) {
    Structure s;
    s.add(elements);
    const auto value = frequency_responses(s, Eigen::VectorXd::Zero(1), "beam.tip.z", {strain("beam.g")})(0, 0);
    EXPECT_NEAR(value.real(), expected, 1e-6 * std::abs(expected));
    EXPECT_EQ(value.imag(), 0.0);
    const auto refused =
        refusal_of([&] { return frequency_responses(s, Eigen::VectorXd::Zero(1), "beam.tip.z", {strain("beam.h")}); });
    EXPECT_THAT(refused, HasSubstr("there is no strain gauge 'beam.h' (did you mean 'beam.g'?)"));
  }
}

TEST(FiniteElementParts, WrongNamesAreReportedTogether) {
  auto elements = cantilever().node("middle", 99).fix("rot").reduce({}, {"tup", "tip.q"});
  const auto message = refusal_of([&] { return reduce(elements); });
  EXPECT_THAT(message, HasSubstr("finite elements 'beam': node 'middle': the mesh has no node 99"));
  EXPECT_THAT(message, HasSubstr("fix: there is no node 'rot' (did you mean 'root'?)"));
  EXPECT_THAT(message, HasSubstr("boundary: there is no node 'tup' (did you mean 'tip'?)"));
  EXPECT_THAT(message, HasSubstr("'tip.q' has no direction"));
}

TEST(FiniteElementParts, AReductionNeedsABoundaryAndToBeAskedFor) {
  EXPECT_THAT(refusal_of([] { return reduce(cantilever().reduce()); }), HasSubstr("the reduction has no boundary"));
  EXPECT_THAT(refusal_of([] { return reduce(cantilever()); }), HasSubstr("are not to be reduced"));
}

}  // namespace
}  // namespace kalfem
