// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/assembly/fe_linear_model.hpp"
#include "kalfem/model/parameterised_model.hpp"
#include "model/fe_models.hpp"

// Models as functions of their parameters: values, and derivatives against central differences. K, M and C are
// polynomials of low degree in each parameter, so differences over 1e-4 of it are right to its square, 1e-8.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double relative_step = 1e-4, tolerance = 1e-8;

MatrixXd dense(const SparseMatrix& matrix, Index n) {
  return matrix.size() == 0 ? MatrixXd(MatrixXd::Zero(n, n)) : MatrixXd(matrix);
}

void expect_matrix(const MatrixXd& derivative, const MatrixXd& above, const MatrixXd& below, double step,
                   const std::string& what) {
  const MatrixXd difference = (above - below) / (2.0 * step);
  // and the rounding of the values that are subtracted
  const double size = std::max(difference.cwiseAbs().maxCoeff(), 1e-300);
  EXPECT_LE((derivative - difference).cwiseAbs().maxCoeff(),
            tolerance * size + 1e-15 * above.cwiseAbs().maxCoeff() / step)
      << what;
}

void expect_derivatives(const ParameterisedModel& model, const VectorXd& parameters) {
  const auto derivatives = model.derivatives(parameters);
  ASSERT_EQ(static_cast<Index>(derivatives.size()), parameters.size());
  for (Index i = 0; i < parameters.size(); ++i) {
    const double step = relative_step * parameters[i];
    const VectorXd move = step * VectorXd::Unit(parameters.size(), i);
    const auto above = model.at(parameters + move), below = model.at(parameters - move);
    const auto& derivative = derivatives[static_cast<std::size_t>(i)];
    const Index n = above.model.size();
    const std::string name = "parameter " + std::to_string(i);
    expect_matrix(dense(derivative.stiffness, n), above.model.stiffness, below.model.stiffness, step, name + " K");
    expect_matrix(dense(derivative.mass, n), above.model.mass, below.model.mass, step, name + " M");
    expect_matrix(dense(derivative.damping, n), above.model.damping, below.model.damping, step, name + " C");
    for (std::size_t r = 0; r < above.modal_ratios.values.size(); ++r)
      EXPECT_NEAR(derivative.modal_ratios.empty() ? 0.0 : derivative.modal_ratios[r],
                  (above.modal_ratios.values[r] - below.modal_ratios.values[r]) / (2.0 * step),
                  5e-12)  // rounding over the step
          << name;
  }
}

/// In a basis of four columns, made at `here`, the model is the projected one at `there` too.
void expect_projection(const ParameterisedFiniteElements& model, const VectorXd& here, const VectorXd& there) {
  auto reduced = model.at(here).model;
  const Index n = reduced.size();
  MatrixXd basis(n, 4);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < 4; ++j) basis(i, j) = std::sin(1.0 + static_cast<double>(i * (j + 2)));
  const auto project = [&](const SparseMatrix& matrix) {
    return SparseMatrix(MatrixXd(basis.transpose() * MatrixXd(matrix) * basis).sparseView());
  };
  for (auto* matrix : {&reduced.mass, &reduced.damping, &reduced.stiffness}) *matrix = project(*matrix);
  const auto small = model.in_basis(basis, reduced, here).at(there), large = model.at(there);
  for (const auto matrix : {&LinearModel::mass, &LinearModel::damping, &LinearModel::stiffness}) {
    const MatrixXd expected = project(large.model.*matrix);
    EXPECT_LT((MatrixXd(small.model.*matrix) - expected).norm(), 5e-15 * expected.norm());  // rounding
  }
  EXPECT_EQ(small.modal_ratios.values, large.modal_ratios.values);
}

LumpedSubstructure frame() {
  return {.name = "frame",
          .masses = {{"a", 2.0}, {"b", 3.0}},
          .springs = {{"foot", "ground", "a", 4e3, 5.0}, {"storey", "a", "b", 6e3, 2.0}},
          .modal_damping = {0.01, 0.02},
          .rayleigh = {0.3, 1e-4}};
}

template <class Target>
std::vector<ParameterBinding<Target>> all_of(const std::vector<std::pair<std::string, Target>>& named,
                                             const std::vector<std::string>& wanted) {
  std::vector<ParameterBinding<Target>> bindings;
  for (const auto& name : wanted)
    for (const auto& [candidate, target] : named)
      if (candidate == name) bindings.push_back({static_cast<Index>(bindings.size()), target});
  return bindings;
}

TEST(ParameterisedLumped, DerivativesAgreeWithDifferences) {
  const auto substructure = frame();
  const auto bindings =
      all_of(parameters_of(substructure), {"foot.stiffness", "storey.damping", "b.mass", "damping.modal.2",
                                           "damping.mass_factor", "damping.stiffness_factor"});
  ASSERT_EQ(bindings.size(), 6U);
  expect_derivatives(ParameterisedLumped(substructure, bindings, 6), VectorXd{{5e3, 3.0, 2.5, 0.03, 0.2, 2e-4}});
}

TEST(ParameterisedLumped, OneValueMayStandInSeveralPlaces) {
  const auto substructure = frame();
  const auto named = parameters_of(substructure);
  std::vector<ParameterBinding<LumpedParameter>> bindings;
  for (const auto& [name, target] : named)
    if (name.ends_with(".stiffness") || name == "damping.modal")
      bindings.push_back({name == "damping.modal" ? 1 : 0, target});
  const ParameterisedLumped model(substructure, bindings, 2);
  const auto at = model.substructure_at(VectorXd{{7e3, 0.05}});
  EXPECT_EQ(at.springs[0].stiffness, 7e3);
  EXPECT_EQ(at.springs[1].stiffness, 7e3);
  EXPECT_EQ(at.modal_damping, (std::vector<double>{0.05, 0.05}));
  expect_derivatives(model, VectorXd{{7e3, 0.05}});
}

TEST(ParameterisedLumped, IsTheSubstructureItselfAtItsOwnValues) {
  const auto substructure = frame();
  const auto named = parameters_of(substructure);
  for (const auto& [name, target] : named) {
    auto changed = substructure;
    set_value(changed, target, value_of(substructure, target));
    EXPECT_EQ(value_of(changed, target), value_of(substructure, target)) << name;
  }
}

/// A cantilever of two kinds of beams with a mass and a spring at its end.
FiniteElementModel cantilever() {
  Mesh mesh = test::line_mesh({0, 0, 0}, {1, 0, 0}, 4, "root");
  mesh.regions["tip"] = {mesh.regions["root"].back()};
  mesh.regions["root"].pop_back();
  auto model = test::model_of(std::move(mesh));
  model.properties["root"] = test::beam_property(rectangular_section(0.02, 0.03));
  model.properties["tip"] = test::beam_property(rectangular_section(0.01, 0.02));
  model.fixed.push_back({"foot", {0}});
  model.masses.push_back({.name = "end", .node = 4, .mass = 0.5});
  model.springs.push_back({.name = "guide", .from = {4, 2}, .to = {}, .stiffness = 1e4});
  return model;
}

TEST(ParameterisedFiniteElements, DerivativesAgreeWithDifferences) {
  const auto elements = cantilever();
  const std::vector<std::string> wanted = {"steel.youngs_modulus", "steel.density",  "tip.bending_y",
                                           "tip.torsion",          "end.mass",       "guide.stiffness",
                                           "damping.mass_factor",  "damping.modal.1"};
  const auto assembled = std::make_shared<const AssembledModel>(assemble(elements, {.parameters = wanted}));
  const FiniteElementDamping damping{{0.4, 1e-5}, {{0.02}}};
  const auto full = std::make_shared<const LinearModel>(linear_model(elements, *assembled, {}, damping.rayleigh));
  const auto bindings = all_of(parameters_of(*assembled, damping), wanted);
  ASSERT_EQ(bindings.size(), wanted.size());
  const ParameterisedFiniteElements model(assembled, full, damping, bindings, static_cast<Index>(wanted.size()));
  VectorXd values(static_cast<Index>(wanted.size()));
  values << 2.0e11, 7000.0, 1.2, 0.9, 0.4, 2e4, 0.3, 0.015;
  expect_derivatives(model, values);
  expect_projection(model, values, 1.3 * values);

  // At the model's own values it is the model.
  VectorXd own = values;
  own << 2.1e11, 7850.0, 1.0, 1.0, 0.5, 1e4, 0.4, 0.02;
  const auto same = model.at(own);
  // rounding
  EXPECT_LT((MatrixXd(same.model.stiffness) - MatrixXd(full->stiffness)).norm(), 1e-15 * full->stiffness.norm());
  EXPECT_LT((MatrixXd(same.model.damping) - MatrixXd(full->damping)).norm(), 1e-15 * full->damping.norm());
}

TEST(ParameterisedFiniteElements, AShellsThicknessActsOnMembraneAndBendingAlike) {
  auto elements = test::model_of(test::plate_mesh(1.0, 0.5, 3, 2));
  elements.properties["plate"] = ShellProperty{.material = "steel", .thickness = 0.01};
  const auto assembled = std::make_shared<const AssembledModel>(assemble(elements));
  const auto full = std::make_shared<const LinearModel>(linear_model(elements, *assembled, {}, {}));
  const auto bindings = all_of(parameters_of(*assembled, {}), {"plate.thickness"});
  const ParameterisedFiniteElements model(assembled, full, FiniteElementDamping{{0.4, 1e-5}, {}}, bindings, 1);
  expect_derivatives(model, VectorXd{{0.012}});
  expect_projection(model, VectorXd{{0.012}}, VectorXd{{0.02}});
}

}  // namespace
}  // namespace kalfem
