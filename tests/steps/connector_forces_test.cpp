// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "casefile/case_run.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/estimation/sections.hpp"
#include "kalfem/steps/run_study.hpp"

namespace kalfem {
namespace {

/// A wheel on its tyre, which carries 250 N at rest, under a body on a strut.
const std::string quarter_car = R"(
kalfem: 1
substructures:
  car: {masses: {w: 20 kg, b: 200 kg}, damping: {modal: 0 %}}
connectors:
  strut: {from: car.w, to: car.b, law: linear, parameters: {k: 10 kN/m, c: 800 N s/m}}
  tyre: {from: car.ground, to: car.w, law: linear, parameters: {k: 150 kN/m, c: 100 N s/m}}
  load: {from: car.ground, to: car.w, law: preload, parameters: {f0: -250}}
  steady: {from: car.ground, to: car.w, law: preload, parameters: {f0: 250}}
excitation:
  road: {base_displacement: car.ground, random: {rms: 3 mm, band: [0.5, 8 Hz], seed: 2}}
sensors:
  w: {acceleration: car.w, noise: 5 %}
  b: {acceleration: car.b, noise: 5 %}
simulate: {duration: 2 s, sample_rate: 500 Hz, tolerance: 0.1}
estimate: {unknown: {strut.c: {initial: 700 N s/m, std: 20 %}}, settle: 0.2 s}
)";

class ConnectorForces : public testing::Test {
protected:
  void SetUp() override { add_connector_forces(study_, outcome(), section_); }
  [[nodiscard]] const EstimationOutcome& outcome() const { return results_.get<EstimationOutcome>(); }

  Study study_ = test::study_of(quarter_car);
  StudyResults results_ = run_study(study_, "estimate");
  Section section_;
};

/// The strut, whose damping is sought, and the tyre, which stands on the ground and of which nothing is.
TEST_F(ConnectorForces, AreShownOverTimeWithTheirBands) {
  ASSERT_EQ(section_.items.size(), 3u);
  for (const auto& [item, name] : {std::pair{1u, "strut"}, {2u, "tyre"}}) {
    const auto& chart = std::get<Chart>(section_.items[item]);
    EXPECT_EQ(chart.id, std::string(name) + "-force");
    const auto* force = find_quantity(outcome().points, name, ObservedQuantity::connector_force);
    ASSERT_NE(force, nullptr);
    const auto& curve = chart.series.front();
    const double scale = curve.y[700] / force->mean[700];  // to the unit on the axis
    EXPECT_NEAR(scale, chart.y_label == "force [kN]" ? 1e-3 : 1.0, 1e-12) << chart.y_label;
    EXPECT_NEAR(curve.upper[700] - curve.lower[700], scale * 2.0 * 1.959964 * force->deviation[700],
                1e-5 * scale * force->deviation[700]);
  }
  EXPECT_NE(std::get<Chart>(section_.items[2]).title.find("on the ground"), std::string::npos);
}

TEST_F(ConnectorForces, StandInATableWithTheirStaticShare) {
  const auto& table = std::get<Table>(section_.items[0]);
  ASSERT_EQ(table.rows.size(), 2u);
  const auto cell = [&](std::size_t row, const std::string& column) {
    const auto at = std::ranges::find(table.columns, column) - table.columns.begin();
    return table.rows[row].at(static_cast<std::size_t>(at));
  };
  EXPECT_EQ(cell(0, "connector"), "strut");
  EXPECT_EQ(cell(0, "static share"), "-");
  const auto* tyre = find_quantity(outcome().points, "tyre", ObservedQuantity::connector_force);
  const Eigen::VectorXd force = tyre->mean.tail(tyre->mean.size() - outcome().settled);
  const double unit = cell(1, "unit") == "kN" ? 1e3 : 1.0;
  const auto number = [&](const std::string& column) { return unit * std::stod(cell(1, column)); };
  EXPECT_NEAR(number("rms"), std::sqrt(force.squaredNorm() / static_cast<double>(force.size())), 1e-3 * force.norm());
  EXPECT_NEAR(number("largest"), force.maxCoeff(), 0.05 * force.maxCoeff());  // two digits of its deviation
  EXPECT_NEAR(number("static share"), 0.0, 1e-9);                             // the two loads hold each other
  EXPECT_NEAR(number("largest with it"), force.maxCoeff(), 1e-3 * force.maxCoeff());
}

}  // namespace
}  // namespace kalfem
