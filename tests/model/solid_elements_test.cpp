// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <numeric>

#include "kalfem/model/elements/solid.hpp"
#include "model/element_helpers.hpp"
#include "solid_models.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using test::name_of;
using test::scaled_difference;
using test::some_turn;
using test::turned;

constexpr double nu = 0.3;

/// Stress of strain for E = 1 by Hooke's law in Lame's constants.
Matrix6 hooke(double poissons_ratio) {
  const double mu = 0.5 / (1.0 + poissons_ratio);
  const double lambda = poissons_ratio / ((1.0 + poissons_ratio) * (1.0 - 2.0 * poissons_ratio));
  Matrix6 elasticity = Matrix6::Zero();
  elasticity.topLeftCorner<3, 3>().setConstant(lambda);
  elasticity.diagonal() << lambda + 2 * mu, lambda + 2 * mu, lambda + 2 * mu, mu, mu, mu;
  return elasticity;
}

/// Wood-like: three moduli, no symmetry of shear and stretch in global axes.
Matrix6 some_orthotropy() {
  Matrix6 compliance = Matrix6::Zero();
  compliance.diagonal() << 1.0 / 11.0, 1.0 / 0.9, 1.0 / 0.5, 1.0 / 0.7, 1.0 / 0.08, 1.0 / 0.65;
  compliance(0, 1) = compliance(1, 0) = -0.4 / 11.0;
  compliance(0, 2) = compliance(2, 0) = -0.35 / 11.0;
  compliance(1, 2) = compliance(2, 1) = -0.5 / 0.9;
  Matrix6 mix = Matrix6::Identity();  // full, as after a rotation
  mix(0, 3) = 0.2;
  mix(4, 1) = -0.1;
  mix(5, 2) = 0.15;
  return mix.transpose() * compliance.inverse() * mix;
}

enum class Form { even, distorted, curved, slender, tiny, far };
constexpr std::array forms = {Form::even, Form::distorted, Form::curved, Form::slender, Form::tiny, Form::far};
constexpr const char* form_names[] = {"even", "distorted", "curved", "slender", "tiny", "far"};

/// Nodes of an element: the natural ones, its corners shifted without a pattern, its middle nodes between them.
Eigen::Matrix3Xd element_nodes(CellShape shape, Form form) {
  Eigen::Matrix3Xd nodes = natural_nodes(shape);
  if (form == Form::even) return nodes;
  for (Index i = 0; i < corner_count(shape); ++i)
    nodes.col(i) += 0.12 * Eigen::Vector3d(std::sin(7.0 * i), std::cos(5.0 * i), std::sin(3.0 * i + 1.0));
  for (int i = corner_count(shape); i < node_count(shape); ++i) {
    const auto [a, b] = test::ends_of(shape, i);
    nodes.col(i) = 0.5 * (nodes.col(a) + nodes.col(b));
    if (form == Form::curved) nodes.col(i) += 0.04 * Eigen::Vector3d(std::cos(3.0 * i), std::sin(4.0 * i), 0.5);
  }
  switch (form) {
    case Form::slender:
      return Eigen::Vector3d(50.0, 1.0, 4.0).asDiagonal() * nodes;
    case Form::tiny:
      return 1e-6 * nodes;
    case Form::far:
      return (some_turn() * nodes).colwise() + Eigen::Vector3d(300.0, -700.0, 1100.0);
    default:
      return nodes;
  }
}

struct Case {
  CellShape shape;
  SolidKind kind;
  Form form;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const auto shape : test::solid_shapes)
    for (const auto kind : test::solid_kinds)
      for (const auto form : forms) all.push_back({shape, kind, form});
  return all;
}

/// Motions without strain that the documentation grants beside the six rigid ones.
int spurious_motions(CellShape shape, SolidKind kind) {
  if (kind != SolidKind::reduced) return 0;
  switch (shape) {
    case CellShape::hexahedron20:
      return 6;
    case CellShape::wedge15:
      return 3;
    case CellShape::wedge6:
      return 1;
    default:
      return 0;
  }
}

template <typename Field>
Eigen::VectorXd nodal(const Eigen::Matrix3Xd& nodes, const Field& field) {
  Eigen::VectorXd values(3 * nodes.cols());
  for (Index i = 0; i < nodes.cols(); ++i) values.segment<3>(3 * i) = field(Eigen::Vector3d(nodes.col(i)));
  return values;
}

Eigen::VectorXd scaled_eigenvalues(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXd scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues();
}

class SolidLaws : public testing::TestWithParam<Case> {
protected:
  ElementMatrices element(MassKind mass = MassKind::consistent, double poissons_ratio = nu) const {
    return solid(GetParam().shape, nodes(), {"", GetParam().kind, {}}, poissons_ratio, mass);
  }
  Eigen::Matrix3Xd nodes() const { return element_nodes(GetParam().shape, GetParam().form); }
  Eigen::MatrixXd stiffness() const { return element().stiffness.front().matrix; }
  Eigen::MatrixXd mass(MassKind kind) const { return element(kind).mass.front().matrix; }
  bool is_far() const { return GetParam().form == Form::far; }
};

TEST_P(SolidLaws, TermsAreSymmetricWithTheirPowers) {
  const auto one = element();
  ASSERT_EQ(one.stiffness.size(), 1u);
  ASSERT_EQ(one.mass.size(), 1u);
  EXPECT_EQ(one.stiffness.front().powers, (PropertyPowers{.youngs_modulus = 1}));
  EXPECT_EQ(one.mass.front().powers, (PropertyPowers{.density = 1}));
  for (const auto& term : {one.stiffness.front(), one.mass.front()}) {
    EXPECT_EQ(term.matrix.rows(), 3 * node_count(GetParam().shape));
    EXPECT_TRUE(term.matrix == term.matrix.transpose());
  }
}

TEST_P(SolidLaws, SixMotionsAndTheDocumentedOnesAreFree) {
  for (const double ratio : {0.0, nu, 0.499}) {
    const Eigen::VectorXd values = scaled_eigenvalues(element(MassKind::consistent, ratio).stiffness.front().matrix);
    const int free = 6 + spurious_motions(GetParam().shape, GetParam().kind);
    EXPECT_LT(values.head(free).cwiseAbs().maxCoeff(), 2.5e-14)
        << values.transpose();                            // rounding, no negative one either
    EXPECT_GT(values[free], 1e-9) << values.transpose();  // slender and nearly incompressible ones are soft
  }
}

TEST_P(SolidLaws, RigidMotionMeetsNoForce) {
  const Eigen::MatrixXd k = stiffness();
  const Eigen::VectorXd scale = k.diagonal().cwiseSqrt();
  const Eigen::Vector3d centre = nodes().rowwise().mean();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d e = Eigen::Vector3d::Unit(axis);
    const Eigen::VectorXd shift = nodal(nodes(), [&](const Eigen::Vector3d&) { return e; });
    const Eigen::VectorXd turn =
        nodal(nodes(), [&](const Eigen::Vector3d& x) -> Eigen::Vector3d { return e.cross(x - centre); });
    for (const auto& motion : {shift, turn})  // against the forces of the single displacements that make it up
      EXPECT_LT((scale.cwiseInverse().asDiagonal() * k * motion).norm(),  // rounding, of far places more
                (is_far() ? 1e-13 : 1e-14) * (scale.asDiagonal() * motion).norm());
  }
}

TEST_P(SolidLaws, ConstantStrainHasItsEnergyAndTheForcesOfConstantStress) {
  // u = A x on straight-sided elements: K u are the forces of stress D e on the element's surface, whatever the strains
  // are made of: f_i = sigma int grad N_i dV, by the rule of the mass, which is exact.
  if (GetParam().form == Form::curved) return;
  const Eigen::Matrix3d gradient{{0.3, -0.2, 0.5}, {0.1, 0.4, -0.6}, {0.7, 0.2, -0.1}};
  const Eigen::Matrix3d strain = 0.5 * (gradient + gradient.transpose());
  const Eigen::Matrix3d stress = (strain + nu / (1 - 2 * nu) * strain.trace() * Eigen::Matrix3d::Identity()) / (1 + nu);
  const Eigen::Matrix3Xd places = nodes().colwise() - nodes().rowwise().mean();
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(places.size());
  double volume = 0.0;
  for (const auto& at : integration_rule(GetParam().shape, RulePurpose::mass)) {
    const Eigen::Matrix3d tangents = places * at.functions.slopes;
    const double part = at.weight * tangents.determinant();
    const Eigen::Matrix3Xd forces = stress * (at.functions.slopes * tangents.inverse()).transpose();
    expected += part * forces.reshaped();
    volume += part;
  }
  const Eigen::VectorXd motion =
      nodal(places, [&](const Eigen::Vector3d& x) -> Eigen::Vector3d { return gradient * x; });
  // Measured against the forces that cancel in the product: those of one displacement each.
  const Eigen::VectorXd single = stiffness().cwiseAbs() * motion.cwiseAbs();
  EXPECT_LT(((stiffness() * motion - expected).cwiseAbs().array() / single.array()).maxCoeff(),
            is_far() ? 3e-14 : 7e-15);  // rounding
  const double energy = volume * (stress.cwiseProduct(strain)).sum();
  if (GetParam().form != Form::slender) {
    EXPECT_NEAR(motion.dot(stiffness() * motion), energy, 3e-14 * energy);
  }
}

TEST_P(SolidLaws, MatricesTurnWithTheElement) {
  const auto one = element();
  const Eigen::Matrix3Xd moved = (some_turn() * nodes()).colwise() + Eigen::Vector3d(1, 2, 3) * nodes().norm();
  const auto other = solid(GetParam().shape, moved, {"", GetParam().kind, {}}, nu, MassKind::consistent);
  // rounding, found 6e-12 and 4e-15
  const double tolerance = is_far() || GetParam().form == Form::slender ? 6e-11 : 5e-14;
  EXPECT_LT(scaled_difference(other.stiffness.front().matrix, turned(stiffness(), some_turn())), tolerance);
  EXPECT_LT(scaled_difference(other.mass.front().matrix, turned(one.mass.front().matrix, some_turn())), tolerance);
}

/// A turn of the natural shape into itself.
Eigen::Matrix3Xd natural_turn(CellShape shape) {
  Eigen::Matrix3Xd nodes = natural_nodes(shape);
  const Eigen::Matrix3Xd old = nodes;
  if (corner_count(shape) == 8) {  // about the diagonal
    nodes.row(0) = old.row(1);
    nodes.row(1) = old.row(2);
    nodes.row(2) = old.row(0);
  } else {  // of the triangle; of the tetrahedron about its last corner
    const Eigen::RowVectorXd t =
        corner_count(shape) == 4 ? Eigen::RowVectorXd(old.row(2)) : Eigen::RowVectorXd::Zero(old.cols());
    nodes.row(0) = 1.0 - old.row(0).array() - old.row(1).array() - t.array();
    nodes.row(1) = old.row(0);
  }
  return nodes;
}

TEST_P(SolidLaws, FirstNodeIsOfNoAccount) {
  const Eigen::Matrix3Xd natural = natural_nodes(GetParam().shape), turn = natural_turn(GetParam().shape);
  Eigen::Matrix3Xd places = nodes();
  std::vector<Index> order;
  for (Index i = 0; i < natural.cols(); ++i) {
    Index same = 0;
    ASSERT_LT((natural.colwise() - turn.col(i)).colwise().norm().minCoeff(&same), 1e-12);
    places.col(i) = nodes().col(same);
    for (Index a = 0; a < 3; ++a) order.push_back(3 * same + a);
  }
  const auto other = solid(GetParam().shape, places, {"", GetParam().kind, {}}, nu, MassKind::consistent);
  EXPECT_LT(scaled_difference(other.stiffness.front().matrix, stiffness()(order, order)),
            is_far() || GetParam().form == Form::slender ? 1e-9 : 2e-14);  // rounding, found 1.6e-10 and 2e-15
  EXPECT_LT(scaled_difference(other.mass.front().matrix, mass(MassKind::consistent)(order, order)), 1e-14);
}

TEST_P(SolidLaws, GivenElasticityIsThatOfTheMaterial) {
  const auto given = [&](const Matrix6& elasticity) {
    return solid(GetParam().shape, nodes(), {"", GetParam().kind, elasticity}, 0.1, MassKind::consistent)
        .stiffness.front();
  };
  const auto same = given(200.0 * hooke(nu));
  EXPECT_EQ(same.powers, PropertyPowers{});
  EXPECT_LT(scaled_difference(same.matrix, 200.0 * stiffness()), 1e-14);  // rounding
  const Eigen::VectorXd values = scaled_eigenvalues(given(some_orthotropy()).matrix);
  const int free = 6 + spurious_motions(GetParam().shape, GetParam().kind);
  EXPECT_LT(values.head(free).cwiseAbs().maxCoeff(), 1.5e-14);
  EXPECT_GT(values[free], 1e-6);
}

TEST_P(SolidLaws, MassHasTheBodysVolumeCentreAndInertia) {
  // Volume and moments by the flux of x / 3, x^2 / 2 and x^3 / 3 through the faces, int div f dV = int f . n dA. The
  // shape functions hold 1 and x exactly, so that sums over the mass must be those.
  test::SolidProblem flux({1, 1, 1, CellShape::hexahedron8}, [](const auto& x) { return x; }, {});
  flux.model.mesh = {};
  flux.model.mesh.nodes = nodes().colwise() - nodes().rowwise().mean();
  std::vector<Index> all(static_cast<std::size_t>(nodes().cols()));
  std::iota(all.begin(), all.end(), 0);
  flux.model.mesh.add_cell(GetParam().shape, 1, all);
  flux.box.cube = Eigen::Matrix3Xd::Zero(3, nodes().cols());
  flux.forces.setZero(6 * nodes().cols());
  Eigen::Vector3d first = Eigen::Vector3d::Zero(), second = Eigen::Vector3d::Zero();
  double volume = 0.0;
  flux.load_side(0, 0.0, [&](const Eigen::Vector3d& x, const Eigen::Vector3d& n) -> Eigen::Vector3d {
    return {x.dot(n) / 3.0, 0.5 * x.x() * x.x() * n.x(), x.x() * x.x() * x.x() * n.x() / 3.0};
  });
  for (Index i = 0; i < nodes().cols(); ++i) {
    volume += flux.forces[6 * i];
    first.x() += flux.forces[6 * i + 1];
    second.x() += flux.forces[6 * i + 2];
  }
  const double size = flux.model.mesh.nodes.row(0).cwiseAbs().maxCoeff();
  const Eigen::VectorXd one =
      nodal(flux.model.mesh.nodes, [](const Eigen::Vector3d&) { return Eigen::Vector3d::UnitX(); });
  const Eigen::VectorXd x = nodal(flux.model.mesh.nodes, [](const Eigen::Vector3d& place) -> Eigen::Vector3d {
    return {place.x(), 0, 0};
  });
  const Eigen::MatrixXd consistent = mass(MassKind::consistent), lumped = mass(MassKind::lumped);
  const double tolerance = is_far() ? 2e-12 : 2e-14;  // rounding
  EXPECT_NEAR(one.dot(consistent * one), volume, tolerance * volume);
  EXPECT_NEAR(one.dot(lumped * one), volume, tolerance * volume);
  if (GetParam().form != Form::curved) {  // of degree 4 and more along curved sides
    EXPECT_NEAR(one.dot(consistent * x), first.x(), tolerance * volume * size);
    EXPECT_NEAR(x.dot(consistent * x), second.x(), tolerance * volume * size * size);
  }
}

TEST_P(SolidLaws, MassIsPositive) {
  EXPECT_GT(scaled_eigenvalues(mass(MassKind::consistent))[0], 1e-4);
  const Eigen::MatrixXd lumped = mass(MassKind::lumped);
  EXPECT_TRUE(lumped.isDiagonal(0.0));
  EXPECT_GT(lumped.diagonal().minCoeff(), 1e-3 * lumped.diagonal().maxCoeff());
}

INSTANTIATE_TEST_SUITE_P(All, SolidLaws, testing::ValuesIn(cases()), [](const auto& one) {
  return name_of(one.param.shape) + "_" + name_of(one.param.kind) + "_" + form_names[static_cast<int>(one.param.form)];
});

// Shape functions and rules -------------------------------------------------------------------------------------------

TEST(SolidShapes, FunctionsAreOneAtTheirNodeAndSumToOne) {
  for (const auto shape : test::solid_shapes) {
    const auto nodes = natural_nodes(shape);
    for (Index i = 0; i < nodes.cols(); ++i) {
      const auto at = solid_shape_functions(shape, nodes.col(i));
      // rounding
      EXPECT_LT((at.values - Eigen::VectorXd::Unit(nodes.cols(), i)).cwiseAbs().maxCoeff(), 1e-15) << name_of(shape);
    }
    const Eigen::Vector3d place(0.21, 0.34, 0.17);
    const auto at = solid_shape_functions(shape, place);
    EXPECT_NEAR(at.values.sum(), 1.0, 3e-15);  // rounding of twenty terms
    EXPECT_LT((nodes * at.values - place).norm(), 3e-15);
    EXPECT_LT((nodes * at.slopes - Eigen::Matrix3d::Identity()).norm(), 4e-15);
    for (int a = 0; a < 3; ++a) {  // slopes against differences
      const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(a);
      const Eigen::VectorXd slope =
          (solid_shape_functions(shape, place + step).values - solid_shape_functions(shape, place - step).values) /
          2e-6;
      EXPECT_LT((slope - at.slopes.col(a)).cwiseAbs().maxCoeff(), 6e-10);  // rounding over the step
    }
  }
}

double factorial(int n) { return std::tgamma(n + 1.0); }

TEST(SolidRules, MassRulesHaveTheirDegree) {
  // int r^a s^b t^c: a! b! c! / (a + b + c + 3)! on the tetrahedron; a! b! / (a + b + 2)! on the triangle.
  const auto line = [](int n) { return n % 2 == 0 ? 2.0 / (n + 1) : 0.0; };
  for (const auto shape : test::solid_shapes) {
    const bool tetrahedron = corner_count(shape) == 4, wedge = corner_count(shape) == 6;
    const int degree = shape == CellShape::tetrahedron4 ? 2 : 5;
    for (int a = 0; a <= degree; ++a)
      for (int b = 0; a + b <= degree; ++b)
        for (int c = 0; a + b + c <= degree; ++c) {
          double sum = 0.0;
          for (const auto& at : integration_rule(shape, RulePurpose::mass))
            sum += at.weight * std::pow(at.place[0], a) * std::pow(at.place[1], b) * std::pow(at.place[2], c);
          const double exact = tetrahedron ? factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3)
                               : wedge     ? factorial(a) * factorial(b) / factorial(a + b + 2) * line(c)
                                           : line(a) * line(b) * line(c);
          EXPECT_NEAR(sum, exact, 1e-14) << name_of(shape) << " " << a << b << c;  // rounding of up to 64 points
        }
  }
}

// Elements of more than one cell --------------------------------------------------------------------------------------

struct PatchCase {
  CellShape shape;
  SolidKind kind;
};

std::vector<PatchCase> patch_cases() {
  std::vector<PatchCase> all;
  for (const auto shape : test::solid_shapes)
    for (const auto kind : test::solid_kinds) all.push_back({shape, kind});
  return all;
}

class SolidPatch : public testing::TestWithParam<PatchCase> {};

TEST_P(SolidPatch, InnerNodesOfADistortedBlockFollowALinearFieldOnItsSurface) {
  for (const double ratio : {0.0, 0.3, 0.499}) {
    const test::SolidProblem problem(
        {3, 3, 3, GetParam().shape, 0.2},
        [](const auto& cube) -> Eigen::Vector3d {
          return {2 * cube.x(), cube.y(), 1.5 * cube.z()};
        },
        {1.0, ratio, 1.0}, GetParam().kind);
    const auto assembled = assemble(problem.model);
    const Eigen::MatrixXd k = evaluate(assembled.stiffness, assembled.parameters);
    const Eigen::Matrix3d gradient{{0.3, -0.2, 0.5}, {0.1, 0.4, -0.6}, {0.7, 0.2, -0.1}};
    std::vector<Index> inner, outer;
    Eigen::VectorXd field(assembled.size());
    for (Index i = 0; i < assembled.size(); ++i) {
      const auto& dof = assembled.dofs[static_cast<std::size_t>(i)];
      const Eigen::Vector3d cube = problem.box.cube.col(dof.node);
      const bool surface = cube.minCoeff() < 1e-9 || cube.maxCoeff() > 1.0 - 1e-9;
      (surface ? outer : inner).push_back(i);
      field[i] = gradient.row(dof.direction).dot(problem.model.mesh.nodes.col(dof.node));
    }
    const Eigen::MatrixXd inside = k(inner, inner), coupled = k(inner, outer);
    const Eigen::VectorXd found = inside.ldlt().solve(-coupled * field(outer));
    EXPECT_LT((found - field(inner)).cwiseAbs().maxCoeff(), 1e-12) << ratio;  // rounding
  }
}

INSTANTIATE_TEST_SUITE_P(All, SolidPatch, testing::ValuesIn(patch_cases()),
                         [](const auto& one) { return name_of(one.param.shape) + "_" + name_of(one.param.kind); });

// Faults --------------------------------------------------------------------------------------------------------------

std::string complaint(CellShape shape, const Eigen::Matrix3Xd& nodes, SolidKind kind = SolidKind::standard) {
  try {
    solid(shape, nodes, {"", kind, {}}, nu, MassKind::consistent);
  } catch (const ElementShapeError& error) {
    return error.what();
  }
  return "";
}

TEST(SolidFaults, WrongShapesAndNumbersOfNodesAreRejected) {
  EXPECT_NE(complaint(CellShape::quadrilateral4, Eigen::Matrix3Xd::Random(3, 4)).find("not a solid"),
            std::string::npos);
  EXPECT_NE(complaint(CellShape::hexahedron8, Eigen::Matrix3Xd::Random(3, 6)).find("8 nodes, not 6"),
            std::string::npos);
}

TEST(SolidFaults, EveryShapeInsideOutIsRejected) {
  for (const auto shape : test::solid_shapes)
    for (const auto kind : test::solid_kinds) {
      const Eigen::Matrix3Xd mirrored = Eigen::Vector3d(1, 1, -1).asDiagonal() * natural_nodes(shape);
      EXPECT_NE(complaint(shape, mirrored, kind).find("inside out"), std::string::npos) << name_of(shape);
    }
}

TEST(SolidFaults, FlatShapesAreRejected) {
  for (const auto shape : test::solid_shapes)
    for (const double height : {0.0, 1e-13}) {
      Eigen::Matrix3Xd flat = element_nodes(shape, Form::distorted);
      flat.row(2) *= height;
      EXPECT_NE(complaint(shape, flat), "") << name_of(shape);
    }
}

TEST(SolidFaults, CoincidingNodesAreNamed) {
  for (const auto shape : test::solid_shapes) {
    Eigen::Matrix3Xd nodes = natural_nodes(shape);
    nodes.col(2) = nodes.col(0);
    EXPECT_NE(complaint(shape, nodes).find("nodes 1 and 3 coincide"), std::string::npos) << complaint(shape, nodes);
  }
}

TEST(SolidFaults, CoordinatesThatAreNoNumbersAreRejected) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Eigen::Matrix3Xd nodes = natural_nodes(CellShape::hexahedron8);
    nodes(1, 3) = bad;
    EXPECT_NE(complaint(CellShape::hexahedron8, nodes).find("finite"), std::string::npos);
  }
}

// The Jacobian decides where the element uses it: at the integration points.
TEST(SolidFaults, FoldedAndCrossedHexahedraAreRejected) {
  Eigen::Matrix3Xd folded = natural_nodes(CellShape::hexahedron8);
  folded.col(6).setConstant(0.3);  // the Jacobian there is negative below 1/3, positive at all points of integration
  EXPECT_EQ(complaint(CellShape::hexahedron8, folded), "");
  folded.col(6).setConstant(-0.5);
  EXPECT_NE(complaint(CellShape::hexahedron8, folded).find("at an integration point"), std::string::npos);
  Eigen::Matrix3Xd crossed = natural_nodes(CellShape::hexahedron8);
  crossed.col(5).swap(crossed.col(6));
  EXPECT_NE(complaint(CellShape::hexahedron8, crossed), "");
  Eigen::Matrix3Xd sides = natural_nodes(CellShape::hexahedron20);
  sides.col(8) = Eigen::Vector3d(0.0, 0.9, -1.0);  // a side bulges nearly to the opposite one
  sides.col(10) = Eigen::Vector3d(0.0, -0.9, -1.0);
  EXPECT_NE(complaint(CellShape::hexahedron20, sides), "");
}

TEST(SolidFaults, AnAngleOf180DegreesAndQuarterPointsAreNoFault) {
  Eigen::Matrix3Xd straight = natural_nodes(CellShape::hexahedron8);
  straight.col(2) = Eigen::Vector3d(0, 0, -1);
  straight.col(6) = Eigen::Vector3d(0, 0, 1);
  EXPECT_EQ(complaint(CellShape::hexahedron8, straight), "");
  Eigen::Matrix3Xd quarter = natural_nodes(CellShape::hexahedron20);
  for (const int middle : {8, 10, 12, 14}) quarter(0, middle) = -0.5;
  EXPECT_EQ(complaint(CellShape::hexahedron20, quarter), "");
}

TEST(SolidFaults, ElasticityThatGainsEnergyIsRejected) {
  Matrix6 bad = hooke(nu);
  bad(0, 0) = -1.0;
  const auto nodes = natural_nodes(CellShape::hexahedron8);
  EXPECT_THROW(solid(CellShape::hexahedron8, nodes, {"", SolidKind::standard, bad}, nu, MassKind::consistent),
               InvalidInput);
  bad = hooke(nu);
  bad(0, 1) = 0.0;
  EXPECT_THROW(solid(CellShape::hexahedron8, nodes, {"", SolidKind::standard, bad}, nu, MassKind::consistent),
               InvalidInput);
}

}  // namespace
}  // namespace kalfem
