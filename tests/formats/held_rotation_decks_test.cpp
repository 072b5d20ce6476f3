// SPDX-License-Identifier: Apache-2.0
// Decks of shells whose rotations about the normal are held everywhere, along global axes, axes of the nodes, in the
// model or in a step: the membrane is as stiff as with free ones.
#include <gtest/gtest.h>

#include <set>

#include "kalfem/formats/abaqus.hpp"
#include "kalfem/formats/nastran.hpp"
#include "kalfem/model/statics/statics.hpp"

namespace kalfem::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

enum class Program { abaqus, nastran };

/// How a deck holds rotations.
struct Hold {
  std::string directions = {};  ///< of all nodes; "456": all rotations
  bool own_axes = false;        ///< *TRANSFORM or CD: x and y in the plane
  bool in_step = false;         ///< in the step, of Abaqus
  bool in_second = false;       ///< in the second of two steps alone
};

/// A trapezium whose left side is clamped, divided into quadrilaterals; its sides stand along y.
struct Shape {
  double length, left, right, rise;  ///< the right side begins at y = rise
  int along, across;                 ///< quadrilaterals
};
/// Cook's panel, v = 23.96 under a unit force.
constexpr Shape cook = {48.0, 44.0, 16.0, 44.0, 8, 8};
constexpr Shape strip = {10.0, 1.0, 0.5, 0.25, 20, 1};

/// The panel of quadrilaterals or twice as many triangles, with its plane turned.
class Panel {
public:
  Panel(Program program, bool triangles, Matrix3d turn, const Shape& shape = cook)
      : program_(program), triangles_(triangles), turn_(std::move(turn)), shape_(shape) {}

  /// Of the middle of the free end, per force [m/N], along a direction of the plane before its turn.
  [[nodiscard]] double deflection(const Hold& hold, int direction) const {
    const Deck deck = read(hold, direction);
    if (!hold.in_second) {
      EXPECT_EQ(deck.model.mesh.node_count(), last());  // the shells keep the nodes of the deck
    }
    const auto moved = solve_statics(deck.model, deck.load_cases.at(hold.in_second ? 1 : 0)).displacements;
    const auto node = NodeFinder(deck.model.mesh).find(number(shape_.along, (shape_.across + 1) / 2));
    return turn_.col(direction).dot(moved.segment<3>(6 * node));
  }

private:
  [[nodiscard]] int number(int i, int j) const { return 1 + (shape_.across + 1) * i + j; }
  [[nodiscard]] int last() const { return number(shape_.along, shape_.across); }

  [[nodiscard]] Vector3d place(int i, int j) const {
    const double u = 1.0 * i / shape_.along, v = 1.0 * j / shape_.across;
    return turn_ *
           Vector3d(shape_.length * u, shape_.rise * u + v * (shape_.left + u * (shape_.right - shape_.left)), 0.0);
  }

  static std::string words(const Vector3d& values, const char* format) {
    char text[120];
    std::snprintf(text, sizeof text, format, values[0], values[1], values[2]);
    return text;
  }

  [[nodiscard]] std::string cells(const std::string& quadrilateral, const std::string& triangle) const {
    std::string text;
    int count = 0;
    const auto add = [&](const std::string& begin, std::initializer_list<int> nodes) {
      text += begin;
      text.replace(text.rfind('#'), 1, std::to_string(++count));
      for (const int node : nodes) text += "," + std::to_string(node);
      text += "\n";
    };
    for (int i = 0; i < shape_.along; ++i)
      for (int j = 0; j < shape_.across; ++j) {
        const int a = number(i, j), b = number(i + 1, j), c = number(i + 1, j + 1), d = number(i, j + 1);
        if (triangles_) {
          add(triangle, {a, b, c});
          add(triangle, {a, c, d});
        } else {
          add(quadrilateral, {a, b, c, d});
        }
      }
    return text;
  }

  [[nodiscard]] Deck read(const Hold& hold, int direction) const {
    const bool is_abaqus = program_ == Program::abaqus;
    const Vector3d force = hold.own_axes && is_abaqus ? Vector3d::Unit(direction) : Vector3d(turn_.col(direction));
    return is_abaqus ? parse_abaqus(abaqus(hold, force), "deck.inp", {}, {.load_cases = true})
                     : parse_nastran(nastran(hold, force), "deck.bdf", {}, {.load_cases = true});
  }

  [[nodiscard]] std::string abaqus(const Hold& hold, const Vector3d& force) const {
    std::string text = "*NODE, NSET=ALL\n", held = hold.directions.empty() ? "" : "*BOUNDARY\n", loads;
    for (int i = 0; i <= shape_.along; ++i)
      for (int j = 0; j <= shape_.across; ++j)
        text += std::to_string(number(i, j)) + words(place(i, j), ", %.12g, %.12g, %.12g\n");
    text += std::string("*ELEMENT, ELSET=E, TYPE=") + (triangles_ ? "S3\n" : "S4\n") + cells("#", "#") +
            "*NSET, NSET=ROOT, GENERATE\n1, " + std::to_string(number(0, shape_.across)) +
            "\n*MATERIAL, NAME=M\n*ELASTIC\n1., .3333333333\n*SHELL SECTION, ELSET=E, "
            "MATERIAL=M\n1.\n";
    if (hold.own_axes)
      text += "*TRANSFORM, NSET=ALL\n" + words(turn_.col(0), "%.12g, %.12g, %.12g,") +
              words(turn_.col(1), "%.12g, %.12g, %.12g\n");
    for (const char c : hold.directions) held += std::string("ALL, ") + c + ", " + c + "\n";
    text += "*BOUNDARY\nROOT, 1, 6\n" + (hold.in_step || hold.in_second ? "" : held) + "*STEP\n*STATIC\n" +
            (hold.in_step ? held : "");
    for (int j = 0; j <= shape_.across; ++j)
      for (int k = 0; k < 3; ++k)
        loads += std::to_string(number(shape_.along, j)) + ", " + std::to_string(k + 1) + ", " +
                 std::to_string(share(j) * force[k]) + "\n";
    text += "*CLOAD\n" + loads + "*END STEP\n";
    return hold.in_second ? text + "*STEP\n*STATIC\n" + held + "*END STEP\n" : text;
  }

  [[nodiscard]] std::string nastran(const Hold& hold, const Vector3d& force) const {
    std::string text = "SOL 101\nCEND\nSPC = 1\nLOAD = 2\nBEGIN BULK\nMAT1,1,1.,,.333333\nPSHELL,1,1,1.,1,,1\n";
    if (hold.own_axes)
      text +=
          "CORD2R,7,,0.,0.,0." + words(turn_.col(2), ",%.7f,%.7f,%.7f\n") + words(turn_.col(0), ",%.7f,%.7f,%.7f\n");
    for (int i = 0; i <= shape_.along; ++i)
      for (int j = 0; j <= shape_.across; ++j)
        text += "GRID," + std::to_string(number(i, j)) + "," + words(place(i, j), ",%.8g,%.8g,%.8g") +
                (hold.own_axes ? ",7\n" : "\n");
    text +=
        cells("CQUAD4,#,1", "CTRIA3,#,1") + "SPC1,1,123456,1,THRU," + std::to_string(number(0, shape_.across)) + "\n";
    if (!hold.directions.empty())
      text +=
          "SPC1,1," + hold.directions + "," + std::to_string(number(1, 0)) + ",THRU," + std::to_string(last()) + "\n";
    for (int j = 0; j <= shape_.across; ++j)
      text += "FORCE,2," + std::to_string(number(shape_.along, j)) + ",," + std::to_string(share(j)) +
              words(force, ",%.7f,%.7f,%.7f\n");
    return text + "ENDDATA\n";
  }

  [[nodiscard]] double share(int j) const { return (j == 0 || j == shape_.across ? 0.5 : 1.0) / shape_.across; }

  Program program_;
  bool triangles_;
  Matrix3d turn_;
  Shape shape_;
};

Matrix3d no_turn() { return Matrix3d::Identity(); }
Matrix3d tilt() {
  return (Eigen::AngleAxisd(0.7, Vector3d::UnitZ()) * Eigen::AngleAxisd(0.5, Vector3d::UnitX())).toRotationMatrix();
}

/// Of all combinations: program, shape of the cells.
template <typename Test>
void for_each_panel(const Test& test) {
  for (const auto program : {Program::abaqus, Program::nastran})
    for (const bool triangles : {false, true}) {
      SCOPED_TRACE(std::string(program == Program::abaqus ? "Abaqus" : "Nastran") + (triangles ? ", triangles" : ""));
      test(program, triangles);
    }
}

TEST(HeldRotationDecks, MembranesAreAsStiffAsWithFreeRotations) {
  for_each_panel([](Program program, bool triangles) {
    const Panel flat(program, triangles, no_turn()), tilted(program, triangles, tilt());
    const double free = flat.deflection({}, 1);
    EXPECT_NEAR(free / 23.96, triangles ? 0.946 : 0.989, 0.002);
    for (const std::string directions : {"6", "456", "3456"})
      EXPECT_NEAR(flat.deflection({directions}, 1) / free, 1.0, 0.005) << "flat " << directions;
    for (const std::string directions : {"456", "6", "5"})
      EXPECT_NEAR(tilted.deflection({directions}, 1) / free, 1.0, 0.01) << "tilted " << directions;
    for (const std::string directions : {"6", "456", "3456"})
      EXPECT_NEAR(tilted.deflection({directions, true}, 1) / free, 1.0, 0.005) << "own axes " << directions;
    if (program != Program::abaqus) return;
    EXPECT_NEAR(flat.deflection({"456", false, true}, 1) / free, 1.0, 0.005) << "in step";
    EXPECT_NEAR(tilted.deflection({"456", false, true}, 1) / free, 1.0, 0.005) << "tilted, in step";
    EXPECT_NEAR(flat.deflection({"456", false, false, true}, 1) / free, 1.0, 0.005) << "in the second step";
    for (const bool own_axes : {false, true})
      EXPECT_NEAR(tilted.deflection({"456", own_axes, false, true}, 1) / free, 1.0, 0.005) << "second, tilted";
  });
}

/// A slender cantilever, one element deep: L / h up to 20. A linear membrane would lock in it.
TEST(HeldRotationDecks, ATaperedStripIsAsStiffAsWithFreeRotations) {
  for_each_panel([](Program program, bool triangles) {
    const Panel flat(program, triangles, no_turn(), strip), tilted(program, triangles, tilt(), strip);
    const double free = flat.deflection({}, 1);
    for (const std::string directions : {"6", "456", "3456"})
      EXPECT_NEAR(flat.deflection({directions}, 1) / free, 1.0, 0.01) << "flat " << directions;
    EXPECT_NEAR(tilted.deflection({"456"}, 1) / free, 1.0, 0.01);
    EXPECT_NEAR(tilted.deflection({"456", true}, 1) / free, 1.0, 0.01);
  });
}

/// Rotations about axes in the plane stay held: the panel cannot bend, but for transverse shear.
TEST(HeldRotationDecks, TurnsInThePlaneStayHeld) {
  for_each_panel([](Program program, bool triangles) {
    const Panel flat(program, triangles, no_turn()), tilted(program, triangles, tilt());
    const double free = flat.deflection({}, 2), held = flat.deflection({"456"}, 2);
    EXPECT_LT(held, 0.1 * free);
    EXPECT_NEAR(tilted.deflection({"456"}, 2) / held, 1.0, 1e-3);
    EXPECT_NEAR(tilted.deflection({"45", true}, 2) / held, 1.0, 1e-3);
    EXPECT_NEAR(tilted.deflection({"456", true}, 2) / held, 1.0, 1e-3);
    EXPECT_NEAR(tilted.deflection({"6", true}, 2) / free, 1.0, 1e-3);
    EXPECT_NEAR(tilted.deflection({"4", true}, 2) / flat.deflection({"4"}, 2), 1.0, 1e-3);
  });
}

}  // namespace
}  // namespace kalfem::test
