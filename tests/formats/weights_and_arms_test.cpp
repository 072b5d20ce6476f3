// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "formats/abaqus_decks.hpp"
#include "formats/nastran_decks.hpp"
#include "kalfem/model/assembly/rigid_motion.hpp"

// Numbers of decks that no symmetric example shows: unequal weights, bodies off their node, parts that are turned.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double rounding = 1e-14;  ///< of numbers of about one; found up to 1e-15

/// Three nodes on springs of 100 N/m along each axis, and node 9 between them.
const std::string springs = [] {
  std::string text =
      "*NODE\n1, 0, 0, 0\n2, 2, 0, 0\n3, 0, 3, 0\n9, 0.5, 0.5, 0\n*NSET, NSET=one\n1\n*NSET, NSET=two\n2\n*NSET, "
      "NSET=three\n3\n";
  for (int axis = 1; axis <= 3; ++axis) {
    const auto set = "k" + std::to_string(axis);
    text += "*ELEMENT, TYPE=SPRING1, ELSET=" + set + "\n";
    for (int node = 1; node <= 3; ++node) text += std::to_string(10 * axis + node) + ", " + std::to_string(node) + "\n";
    text += "*SPRING, ELSET=" + set + "\n" + std::to_string(axis) + "\n100.\n";
  }
  return text;
}();

/// Motions along z of nodes 1, 2 and 3 under a unit force along z on node 9.
Vector3d shared(const std::string& coupling) {
  const auto model = parse_deck(springs + coupling).model;
  const VectorXd moved = test::displacements(model, {{{3, 2}, 1.0}});
  return {moved[2], moved[8], moved[14]};
}

/// What a force of 1 at the follower puts on the nodes by the weighted mean motion: w_i (a + b x_i + c y_i) with the
/// force and both moments about the follower in balance.
Vector3d loads_by_weights(const Vector3d& w) {
  const Matrix3d places{{1, 0, 0}, {1, 2, 0}, {1, 0, 3}};  // 1, x, y
  const Vector3d follower(1, 0.5, 0.5);
  return w.asDiagonal() * (places * Matrix3d(places.transpose() * w.asDiagonal() * places).inverse() * follower);
}

/// In a deck of Abaqus: CalculiX shares forces without moments. Three nodes carry a force by levers alone; with a
/// fourth node the weights show.
TEST(DistributingCouplings, ShareByUnequalWeights) {
  const std::string fourth =
      "*NODE\n4, 2, 3, 0\n*NSET, NSET=four\n4\n*ELEMENT, TYPE=SPRING1, ELSET=k4\n44, 4\n*SPRING, ELSET=k4\n3\n100.\n";
  const auto loads = [&](const std::string& coupling) {
    const auto model = parse_deck(springs + fourth + coupling).model;
    const VectorXd moved = test::displacements(model, {{{3, 2}, 1.0}});
    return VectorXd(100.0 * (VectorXd(4) << moved[2], moved[8], moved[14], moved[26]).finished());
  };
  const auto expected = [](const Eigen::Vector4d& w) {
    const MatrixXd places = (MatrixXd(4, 3) << 1, 0, 0, 1, 2, 0, 1, 0, 3, 1, 2, 3).finished();
    const Vector3d follower(1, 0.5, 0.5);
    return VectorXd(w.asDiagonal() *
                    (places * Matrix3d(places.transpose() * w.asDiagonal() * places).inverse() * follower));
  };
  const auto coupling = [](const std::string& weights) {
    return "*PREPRINT\n*ELEMENT, TYPE=DCOUP3D, ELSET=d\n90, 9\n*DISTRIBUTING COUPLING, ELSET=d\n" + weights;
  };
  const Eigen::Vector4d even = Eigen::Vector4d::Ones(), uneven(1, 2, 3, 5);
  EXPECT_LT((loads(coupling("one, 1.\ntwo, 1.\nthree, 1.\nfour, 1.\n")) - expected(even)).norm(), rounding);
  EXPECT_LT((loads(coupling("one, 1.\ntwo, 2.\nthree, 3.\nfour, 5.\n")) - expected(uneven)).norm(), rounding);
  EXPECT_GT((expected(even) - expected(uneven)).norm(), 0.05);
  // The same by a surface of nodes, with and without a radius that leaves the last one out.
  const auto surface = [](const std::string& more) {
    return "*SURFACE, NAME=s, TYPE=NODE\none, 1.\ntwo, 2.\nthree, 3.\nfour, 5.\n*COUPLING, CONSTRAINT NAME=c, REF "
           "NODE=9, "
           "SURFACE=s" +
           more + "\n*DISTRIBUTING\n";
  };
  EXPECT_LT((loads(surface("")) - expected(uneven)).norm(), rounding);
  EXPECT_LT((loads(surface(", INFLUENCE RADIUS=2.8")).head(3) - loads_by_weights({1, 2, 3})).norm(), rounding);
  EXPECT_LT(std::abs(loads(surface(", INFLUENCE RADIUS=2.8"))[3]), rounding);
  const std::string far =
      "*NODE\n5, 9, 9, 0\n*NSET, NSET=five\n5\n*ELEMENT, TYPE=SPRING1, ELSET=k5\n55, 5\n*SPRING, ELSET=k5\n3\n100.\n"
      "*SURFACE, NAME=t, TYPE=NODE\none, 1.\ntwo, 2.\nfive, 7.\nthree, 3.\nfour, 5.\n*COUPLING, CONSTRAINT NAME=c, REF "
      "NODE=9, SURFACE=t, INFLUENCE RADIUS=4.\n*DISTRIBUTING\n";
  EXPECT_LT((loads(far) - expected(uneven)).norm(), rounding);
  EXPECT_LT((100.0 * shared(coupling("one, 1.\ntwo, 2.\nthree, 3.\n")) - loads_by_weights({1, 2, 3})).norm(), rounding);
}

/// RBE3 of Nastran: the same by cards.
TEST(DistributingCouplings, ShareByUnequalWeightsOfCards) {
  std::string text = "GRID,9,,.5,.5,0.\nPARAM,AUTOSPC,NO\n";
  const char* places[4] = {"0.,0.", "2.,0.", "0.,3.", "2.,3."};
  for (int i = 0; i < 4; ++i) {
    const auto n = std::to_string(i + 1);
    text += "GRID," + n + ",," + places[i] + ",0.\n";
    for (int c = 1; c <= 3; ++c)
      text += "CELAS2," + n + std::to_string(c) + ",100.," + n + "," + std::to_string(c) + "\n";
  }
  const auto deck = test::nastran(text + "RBE3,1,,9,123456,1.,123,1,2.\n,123,2,3.,123,3,5.,123\n,4\n");
  const VectorXd moved = test::displacements(deck.model, {{{0, 2}, 1.0}});
  const MatrixXd at = (MatrixXd(4, 3) << 1, 0, 0, 1, 2, 0, 1, 0, 3, 1, 2, 3).finished();
  const Eigen::Vector4d w(1, 2, 3, 5);
  const Vector3d follower(1, 0.5, 0.5);
  const VectorXd expected = w.asDiagonal() * (at * Matrix3d(at.transpose() * w.asDiagonal() * at).inverse() * follower);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(100.0 * moved[6 * (i + 1) + 2], expected[i], rounding) << i;
}

/// Inertia about the node of a body with its centre at an arm, by the parallel-axis theorem.
Matrix3d about_node(double m, const Vector3d& arm, const Matrix3d& own) {
  return own + m * (arm.squaredNorm() * Matrix3d::Identity() - arm * arm.transpose());
}

/// *ROTARY INERTIA of a part whose instance is turned by 30 degrees about z: the tensor turns with it.
TEST(PlacedBodies, InertiaOfATurnedInstanceTurns) {
  const Matrix3d own{{2.0, 0.1, 0.2}, {0.1, 3.0, 0.3}, {0.2, 0.3, 4.0}};
  const std::string part =
      "*PART, NAME=p\n*NODE\n1, 1, 2, 0\n*ELEMENT, TYPE=ROTARYI, ELSET=r\n1, 1\n*ROTARY INERTIA, ELSET=r\n2., 3., 4., "
      "0.1, 0.2, "
      "0.3\n*ELEMENT, TYPE=MASS, ELSET=m\n2, 1\n*MASS, ELSET=m\n5.\n*END PART\n*ASSEMBLY, NAME=a\n*INSTANCE, NAME=i, "
      "PART=p\n";
  const auto bodies = [&](const std::string& placing) {
    return parse_deck(part + placing + "*END INSTANCE\n*END ASSEMBLY\n").model;
  };
  const auto inertia_of = [](const FiniteElementModel& model) {
    Matrix3d sum = Matrix3d::Zero();
    for (const auto& mass : model.masses) sum += mass.inertia;
    return sum;
  };
  EXPECT_LT((inertia_of(bodies("")) - own).norm(), rounding);
  const Matrix3d turn = Eigen::AngleAxisd(EIGEN_PI / 6, Vector3d::UnitZ()).toRotationMatrix();
  const auto turned = bodies("1., 0., 0.\n1., 0., 0., 1., 0., 1., 30.\n");
  EXPECT_LT((inertia_of(turned) - turn * own * turn.transpose()).norm(), rounding);
  // The node is moved first and turned then, about the axis through (1, 0, 0).
  const Vector3d expected = Vector3d(1, 0, 0) + turn * (Vector3d(2, 2, 0) - Vector3d(1, 0, 0));
  EXPECT_LT((Vector3d(turned.mesh.nodes.col(0)) - expected).norm(), rounding);
}

/// CONM2 with an offset in a turned system, and as absolute coordinates.
TEST(PlacedBodies, OffsetsOfMassesAreArms) {
  const std::string system = "CORD2R,7,,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\nGRID,1,,1.,2.,3.\n";  // its x along global y
  const Matrix3d axes = (Matrix3d() << 0, -1, 0, 1, 0, 0, 0, 0, 1).finished();
  const Matrix3d own{{2.0, -0.1, -0.2}, {-0.1, 3.0, -0.3}, {-0.2, -0.3, 4.0}};
  const auto body = [&](const std::string& card) { return test::nastran(system + card).model.masses.at(0); };
  const auto plain = body("CONM2,1,1,0,6.,.1,.2,.3\n,2.,.1,3.,.2,.3,4.\n");
  EXPECT_LT((plain.offset - Vector3d(0.1, 0.2, 0.3)).norm(), rounding);
  EXPECT_LT((plain.inertia - own).norm(), rounding);
  const auto turned = body("CONM2,1,1,7,6.,.1,.2,.3\n,2.,.1,3.,.2,.3,4.\n");
  EXPECT_LT((turned.offset - axes * Vector3d(0.1, 0.2, 0.3)).norm(), rounding);
  EXPECT_LT((turned.inertia - axes * own * axes.transpose()).norm(), rounding);
  const auto absolute = body("CONM2,1,1,-1,6.,1.1,2.2,3.3\n");
  EXPECT_LT((absolute.offset - Vector3d(0.1, 0.2, 0.3)).norm(), rounding);
  const auto weighed = body("PARAM,WTMASS,.5\nCONM2,1,1,0,6.,.1,.2,.3\n,2.,.1,3.,.2,.3,4.\n");
  EXPECT_NEAR(weighed.mass, 3.0, rounding);
  EXPECT_LT((weighed.inertia - 0.5 * own).norm(), rounding);
}

/// T = (v + omega x arm)^2 m / 2 + omega^T I omega / 2 for any motion of the node.
TEST(PlacedBodies, MatrixHasTheKineticEnergyOfTheBody) {
  PointMass body{"b", 0, 3.0, Matrix3d{{2.0, 0.1, 0.2}, {0.1, 3.0, 0.3}, {0.2, 0.3, 4.0}}, {0.3, -0.4, 0.5}};
  const auto matrix = point_mass(body);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      Eigen::Matrix<double, 6, 1> motion =
          Eigen::Matrix<double, 6, 1>::Unit(i) + 0.7 * Eigen::Matrix<double, 6, 1>::Unit(j);
      const Vector3d v = motion.head<3>(), omega = motion.tail<3>();
      const double energy =
          0.5 * body.mass * (v + omega.cross(body.offset)).squaredNorm() + 0.5 * omega.dot(body.inertia * omega);
      EXPECT_NEAR(0.5 * motion.dot(matrix * motion), energy, rounding) << i << " " << j;
    }
  EXPECT_LT((matrix.bottomRightCorner<3, 3>() - about_node(3.0, body.offset, body.inertia)).norm(), rounding);
}

/// Bars: E A / L along, nothing across.
TEST(Bars, CarryAlongTheirAxisAlone) {
  const double expected = 2.1e11 * 3e-4 / 2.5;
  const auto bar = parse_deck("*NODE\n1, 0, 0, 0\n2, 1.5, 2, 0\n*ELEMENT, TYPE=T3D2, ELSET=e\n1, 1, 2\n" + deck_steel +
                              "*SOLID SECTION, ELSET=e, MATERIAL=steel\n3e-4\n*BOUNDARY\n1, 1, 3\n");
  const auto truss = assemble(bar.model);
  const MatrixXd k(evaluate(truss.stiffness, truss.parameters));
  const Index x = truss.find({1, 0}), y = truss.find({1, 1});
  EXPECT_NEAR(k(x, x), expected * 0.36, rounding * expected);
  EXPECT_NEAR(k(y, y), expected * 0.64, rounding * expected);
  EXPECT_NEAR(k(x, y), expected * 0.48, rounding * expected);
  const auto rod =
      test::nastran("MAT1,1,2.1E11,,.3,7850.\nPROD,1,1,3.E-4\nGRID,1,,,,,,123456\nGRID,2,,1.5,2.,0.\nCROD,1,1,1,2\n");
  const auto assembled = assemble(rod.model);
  const MatrixXd stiffness(evaluate(assembled.stiffness, assembled.parameters));
  // Across its axis the node has no stiffness and is held: it moves along (0.6, 0.8), by y / 0.8.
  const Index along = assembled.find({1, 1});
  ASSERT_GE(along, 0);
  EXPECT_EQ(assembled.find({1, 0}), -1);
  EXPECT_NEAR(stiffness(along, along), expected / 0.64, rounding * expected);
  EXPECT_NEAR(test::masses(rod.model).mass, 7850 * 3e-4 * 2.5, rounding);
}

}  // namespace
}  // namespace kalfem
