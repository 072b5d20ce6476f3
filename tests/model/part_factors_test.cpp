// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/part_factors.hpp"

#include <gtest/gtest.h>

#include "kalfem/model/assembly/fe_linear_model.hpp"
#include "kalfem/model/mesh/split_quadratic_shells.hpp"
#include "kalfem/model/statics/statics.hpp"
#include "kalfem/model/statics/stresses.hpp"
#include "model/fe_models.hpp"

namespace kalfem {
namespace {

using namespace test;
using Cells = std::vector<Eigen::Index>;

/// A plate of 4 x 2 cells, the right half of another material, clamped at its left edge.
FiniteElementModel plate() {
  Mesh mesh = plate_mesh(1.0, 0.5, 4, 2, "left");
  auto& left = mesh.regions["left"];
  for (const Eigen::Index cell : Cells{2, 3, 6, 7}) {
    mesh.regions["right"].push_back(cell);
    std::erase(left, cell);
  }
  mesh.element_sets["CORNER"] = {3};
  auto model = model_of(mesh);
  model.materials["alloy"] = {.youngs_modulus = 7e10, .poissons_ratio = 0.33, .density = 2700.0};
  model.properties["left"] = ShellProperty{"steel", 0.004};
  model.properties["right"] = ShellProperty{"alloy", 0.01};
  model.fixed = {{"edge", {0, 5, 10}}};
  return model;
}

/// The matrices of some elements alone, in the degrees of freedom of the whole.
Eigen::MatrixXd stiffness_at(const FiniteElementModel& model, const std::string& parameter, double value) {
  auto assembled = assemble(model, {.parameters = {parameter}});
  assembled.parameters.at(parameter) = value;
  return stiffness_of(assembled);
}

TEST(PartFactors, MultiplyTheStiffnessOfTheirElements) {
  auto model = plate();
  const Eigen::MatrixXd whole = stiffness_of(assemble(model));
  add_element_factor(model, "part", {"right"});
  EXPECT_LT(difference(stiffness_at(model, "part.factor", 1.0), whole), 1e-14);
  auto softer = plate();
  softer.materials["alloy"].youngs_modulus *= 0.25;
  EXPECT_LT(difference(stiffness_at(model, "part.factor", 0.25), stiffness_of(assemble(softer))), 1e-14);
  EXPECT_LT(difference(mass_of(assemble(model, {.parameters = {"part.factor"}})), mass_of(assemble(plate()))), 1e-14);
}

TEST(PartFactors, MultiplyTheMassWhereAsked) {
  for (const FactorOf of : {FactorOf::mass, FactorOf::both}) {
    auto model = plate();
    add_element_factor(model, "part", {"alloy"}, of, 3.0);
    auto heavier = plate();
    heavier.materials["alloy"].density *= 3.0;
    if (of == FactorOf::both) heavier.materials["alloy"].youngs_modulus *= 3.0;
    for (const std::vector<std::string>& asked :
         {std::vector<std::string>{"part.factor"}, std::vector<std::string>{}}) {
      const auto assembled = assemble(model, {.parameters = asked});
      EXPECT_EQ(assembled.parameters.contains("part.factor"), !asked.empty());
      EXPECT_LT(difference(mass_of(assembled), mass_of(assemble(heavier))), 1e-14);
      EXPECT_LT(difference(stiffness_of(assembled), stiffness_of(assemble(heavier))), 1e-14);
      Matrix6 rigid = Matrix6::Zero(), expected = Matrix6::Zero();
      for (const auto& term : assembled.rigid_mass)
        rigid += affine_factor(term.powers, assembled.parameters) * term.matrix;
      const auto plain = assemble(heavier);
      for (const auto& term : plain.rigid_mass) expected += affine_factor(term.powers, plain.parameters) * term.matrix;
      EXPECT_LT(difference(rigid, expected), 1e-14);
    }
  }
}

TEST(PartFactors, OfOverlappingPartsMultiply) {
  auto model = plate();
  add_element_factor(model, "right", {"right"}, FactorOf::stiffness, 2.0);
  add_element_factor(model, "corner", {"CORNER"}, FactorOf::stiffness, 1.5);
  auto expected = plate();
  expected.mesh.regions["corner"] = {3};
  std::erase(expected.mesh.regions["right"], 3);
  expected.materials["twice"] = expected.materials["thrice"] = expected.materials["alloy"];
  expected.materials["twice"].youngs_modulus *= 2.0;
  expected.materials["thrice"].youngs_modulus *= 3.0;
  expected.properties["right"] = ShellProperty{"twice", 0.01};
  expected.properties["corner"] = ShellProperty{"thrice", 0.01};
  EXPECT_LT(difference(stiffness_of(assemble(model)), stiffness_of(assemble(expected))), 1e-14);
  EXPECT_LT(difference(stiffness_of(assemble(model, {.at_present_values = true})), stiffness_of(assemble(expected))),
            1e-14);
}

TEST(PartFactors, OfMatricesWithDampingHaveExactDerivatives) {
  auto model = plate();
  const std::vector<NodalDof> dofs = {{4, 2}, {9, 2}};
  const Eigen::Matrix2d unit{{1.0, -1.0}, {-1.0, 1.0}};
  NodalMatrices brace{"", dofs, (1e5 * unit).sparseView(), (0.3 * Eigen::Matrix2d::Identity()).sparseView(),
                      (40.0 * unit).sparseView()};
  add_matrix_factor(model, "brace", brace, 0.5);
  const auto assembled = std::make_shared<const AssembledModel>(assemble(model, {.parameters = {"brace.factor"}}));
  const FiniteElementDamping damping{.rayleigh = {0.2, 1e-4}};
  const auto full = std::make_shared<const LinearModel>(linear_model(model, *assembled, {}, damping.rayleigh));
  const ParameterisedFiniteElements parameterised(assembled, full, damping,
                                                  {{0, {FiniteElementParameter::Kind::matrix, "brace.factor", 0}}}, 1);
  const auto at = [&](double value) { return parameterised.at(Eigen::VectorXd::Constant(1, value)).model; };
  const auto slope = parameterised.derivatives(Eigen::VectorXd::Constant(1, 0.5)).front();
  EXPECT_LT(difference(slope.stiffness, at(1.5).stiffness - at(0.5).stiffness), 1e-9);
  EXPECT_LT(difference(slope.mass, at(1.5).mass - at(0.5).mass), 1e-9);
  EXPECT_LT(difference(slope.damping, at(1.5).damping - at(0.5).damping), 1e-9);
  EXPECT_LT(difference(at(0.5).damping, full->damping), 1e-14);
  EXPECT_NEAR(Eigen::MatrixXd(slope.damping).cwiseAbs().maxCoeff(), 40.0 + 1e-4 * 1e5 + 0.2 * 0.3, 1e-9);

  // The same in few coordinates.
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(full->size(), 3);
  for (Eigen::Index j = 0; j < 3; ++j)
    for (Eigen::Index i = 0; i < full->size(); ++i)
      basis(i, j) = std::sin(0.3 * static_cast<double>((j + 1) * (i + 1)));
  const Eigen::VectorXd start = Eigen::VectorXd::Constant(1, 0.5);
  LinearModel reduced = *full;
  reduced.stiffness = Eigen::MatrixXd(basis.transpose() * full->stiffness * basis).sparseView();
  reduced.mass = Eigen::MatrixXd(basis.transpose() * full->mass * basis).sparseView();
  reduced.damping = Eigen::MatrixXd(basis.transpose() * full->damping * basis).sparseView();
  const auto small = parameterised.in_basis(basis, reduced, start);
  const auto moved = small.at(Eigen::VectorXd::Constant(1, 2.0)).model;
  EXPECT_LT(difference(moved.damping, basis.transpose() * at(2.0).damping * basis), 1e-12);
  EXPECT_LT(difference(moved.stiffness, basis.transpose() * at(2.0).stiffness * basis), 1e-12);
}

// A factor of all elements of a material is another modulus and density of it, in stresses and section forces too.
TEST(PartFactors, StressesAreThoseOfTheFactoredElements) {
  auto factored = plate(), other = plate();
  add_element_factor(factored, "right", {"right"}, FactorOf::both, 1.7);
  other.materials.at("alloy").youngs_modulus *= 1.7;
  other.materials.at("alloy").density *= 1.7;
  const LoadCase load{.name = "own weight", .gravity = {0.0, 3.0, -9.81}};
  const auto found = recover_stresses(factored, solve_statics(factored, load).displacements, load.field());
  const auto expected = recover_stresses(other, solve_statics(other, load).displacements, load.field());
  for (std::size_t region = 0; region < 2; ++region)
    for (std::size_t i = 0; i < found[region].cells.size(); ++i) {
      const Stress &is = found[region].cells[i].layers[0].centre, &should = expected[region].cells[i].layers[0].centre;
      EXPECT_LT((is - should).norm(), 1e-9 * should.norm());
      EXPECT_LT((found[region].resultants[i].values - expected[region].resultants[i].values).norm(),
                1e-9 * expected[region].resultants[i].values.norm());
    }
}

// A cantilever under its own weight: the support carries the weight of the factored mass, whatever the stiffness.
TEST(PartFactors, SectionForcesCarryTheFactoredMass) {
  auto beam = beam_model({2.0, 0.0, 0.0}, 4, rectangular_section(0.02, 0.03));
  beam.fixed = {{.name = "clamp", .nodes = {0}}};
  add_element_factor(beam, "heavy", {"line"}, FactorOf::mass, 2.0);
  add_element_factor(beam, "stiff", {"line"}, FactorOf::stiffness, 3.0);
  const LoadCase load{.name = "own weight", .gravity = {0.0, 0.0, -9.81}};
  const auto forces = recover_stresses(beam, solve_statics(beam, load).displacements, load.field())[0].beams;
  const double weight = 2.0 * beam.materials.begin()->second.density * 0.02 * 0.03 * 2.0 * 9.81;
  EXPECT_NEAR(forces[0].ends[0].segment(1, 2).norm(), weight, 1e-8 * weight);
  EXPECT_NEAR(forces[0].ends[0].tail(2).norm(), weight * 1.0, 1e-8 * weight);
  EXPECT_NEAR(forces[3].ends[1].norm(), 0.0, 1e-8 * weight);
}

TEST(PartFactors, FollowSplitShells) {
  Mesh mesh;
  for (const auto& place : std::vector<Eigen::Vector3d>{
           {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0, 0}, {1, 0.5, 0}, {0.5, 1, 0}, {0, 0.5, 0}})
    add_node(mesh, place);
  add_cell(mesh, "plate", CellShape::quadrilateral8, {0, 1, 2, 3, 4, 5, 6, 7});
  mesh.element_sets["ALL"] = {0};
  auto model = model_of(mesh);
  model.properties = {{"plate", ShellProperty{"steel", 0.01}}};
  add_element_factor(model, "a", {"plate"});
  replace_quadratic(model);
  EXPECT_EQ(model.factors.front().cells.size(), 4u);
  EXPECT_EQ(model.mesh.element_sets.at("ALL").size(), 4u);
}

TEST(PartFactors, NamesMeanElements) {
  const auto model = plate();
  EXPECT_EQ(elements_named(model, "right"), (Cells{2, 3, 6, 7}));
  EXPECT_EQ(elements_named(model, "alloy"), (Cells{2, 3, 6, 7}));
  EXPECT_EQ(elements_named(model, "CORNER"), (Cells{3}));
  const auto first = std::to_string(model.mesh.cells[2].id), last = std::to_string(model.mesh.cells[4].id);
  EXPECT_EQ(elements_named(model, first), (Cells{2}));
  EXPECT_EQ(elements_named(model, first + "-" + last), (Cells{2, 3, 4}));
}

TEST(PartFactors, MistakesAreNamed) {
  auto model = plate();
  const auto refusal = [&](const std::vector<std::string>& names) {
    return message_of([&] { add_element_factor(model, "a", names); });
  };
  EXPECT_NE(refusal({"rigt"}).find("there are no elements 'rigt' (did you mean 'right'?)"), std::string::npos);
  EXPECT_NE(refusal({"900-999"}).find("there are no elements '900-999'"), std::string::npos);
  EXPECT_EQ(refusal({"right"}), "");
  EXPECT_NE(refusal({"left"}).find("factor 'a' is given twice"), std::string::npos);
  model.mesh.element_sets["steel"] = {7};
  EXPECT_NE(message_of([&] { elements_named(model, "steel"); }).find("is a set of elements and a material"),
            std::string::npos);
  model.factors.push_back({"b"});
  EXPECT_NE(issues_of(model).find("factor 'b' multiplies neither elements nor matrices"), std::string::npos);
  model.matrices.push_back({"m", {}, {}, {}, {}, "c"});
  EXPECT_NE(issues_of(model).find("matrix 'm' has the factor 'c', which the model does not have"), std::string::npos);
}

}  // namespace
}  // namespace kalfem
