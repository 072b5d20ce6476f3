// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/expression_tape.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include <muParser.h>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/laws/expression_derivatives.hpp"
#include "kalfem/system/laws/expression_law.hpp"
#include "kalfem/system/laws/expression_program.hpp"
#include "system/law_bench.hpp"

namespace kalfem {
namespace {

/// An expression of p and q with its derivatives by both, as a program.
struct Compiled {
  explicit Compiled(const std::string& text) {
    const int p = tape.add_variable("p"), q = tape.add_variable("q"), out = tape.compile(text);
    std::vector<int> values = differentiate(tape, out, {p, q});
    values.insert(values.begin(), out);
    ProgramMaker maker(tape, 2);
    std::vector<char> known;
    program = maker.make(values, known);
    for (const int value : values) places.push_back(maker.place(value));
    constants = maker.constants();
    results.assign(static_cast<std::size_t>(maker.result_count() * points_together), 0.0);
  }

  /// Value and both derivatives at each of the points.
  Eigen::ArrayX3d at(Eigen::ArrayXd p, Eigen::ArrayXd q) {
    ColumnTable table{results.data(), constants.data(), p.data(), q.data()};
    run(program, table, p.size());
    Eigen::ArrayX3d answers(p.size(), 3);
    for (Eigen::Index i = 0; i < 3; ++i)
      answers.col(i) = Eigen::Map<const Eigen::ArrayXd>(column(table, places[static_cast<std::size_t>(i)]), p.size());
    return answers;
  }
  Eigen::Array3d at(double p, double q) {
    return at(Eigen::ArrayXd::Constant(1, p), Eigen::ArrayXd::Constant(1, q)).row(0);
  }
  double value(double p, double q) { return at(p, q)[0]; }

  ExpressionTape tape;
  ExpressionProgram program;
  std::vector<Place> places;
  AlignedColumns constants, results;
};

const std::vector<std::string> expressions{
    "p + q*p - 2",
    "-p^2",
    "2^p^q",
    "2^-p",
    "p - q - 1 - p/q/2",
    "p*-q",
    "(p < q) + (p <= q) + 2*(p > q) + 4*(p >= q) + 8*(p == q) + 16*(p != q)",
    "p > 0.5 || q > 2 && p > 3",
    "p > q ? p : q > 1 ? sin(q) : cos(p)",
    "abs(p - 1)*sign(q) + rint(3*p)",
    "sqrt(p) + exp(-q) + ln(p) + log(q) + log2(p) + log10(q)",
    "sin(p) + cos(q) + tan(p/2) + asin(p/3) + acos(q/4) + atan(p) + atan2(p, q)",
    "sinh(p) + cosh(q) + tanh(p*q) + asinh(p) + acosh(1 + q) + atanh(p/3)",
    "min(p, q, 1) + max(p, 2*q) + sum(p, q, 3) + avg(p, q)",
    "p^2 + q^3 + p^q + abs(p)^(q - 1) + p^0.5",
    "1e3*p + .5*q + _pi + _e",
    "(p*q + 1)*(p*q + 1) - (p*q)",
};

double by_mu_parser(const std::string& text, double p, double q) {
  mu::Parser parser;
  parser.DefineVar("p", &p);
  parser.DefineVar("q", &q);
  parser.SetExpr(text);
  return parser.Eval();
}

TEST(ExpressionTape, GivesTheNumbersOfMuParser) {
  for (const auto& text : expressions) {
    Compiled compiled(text);
    for (const auto& [p, q] : {std::pair{0.7, 1.3}, {1.9, 0.4}, {1.0, 1.0}, {2.5, 2.5}}) {
      const double expected = by_mu_parser(text, p, q);
      EXPECT_NEAR(compiled.value(p, q), expected, 1e-14 * (1.0 + std::abs(expected))) << text;
    }
  }
}

TEST(ExpressionTape, GivesExactDerivatives) {
  constexpr double step = 1e-5;
  for (const auto& text : expressions) {
    Compiled compiled(text);
    for (const auto& [p, q] : {std::pair{0.71, 1.37}, {1.93, 0.41}}) {
      const double by_p = (compiled.value(p + step, q) - compiled.value(p - step, q)) / (2.0 * step);
      const double by_q = (compiled.value(p, q + step) - compiled.value(p, q - step)) / (2.0 * step);
      const Eigen::Array3d found = compiled.at(p, q);
      EXPECT_NEAR(found[1], by_p, 2e-8 * (1.0 + std::abs(by_p))) << text;
      EXPECT_NEAR(found[2], by_q, 2e-8 * (1.0 + std::abs(by_q))) << text;
    }
  }
}

TEST(ExpressionTape, LeavesNoTraceOfABranchThatIsNotTaken) {
  Compiled compiled("p > 0 ? sqrt(p) : 3*p");
  EXPECT_DOUBLE_EQ(compiled.value(-1.0, 0.0), -3.0);
  EXPECT_DOUBLE_EQ(compiled.at(-1.0, 0.0)[1], 3.0);
  EXPECT_DOUBLE_EQ(Compiled("max(ln(p), 2*q) + p/q").at(-1.0, 0.5)[2], 2.0 + 4.0);
  EXPECT_DOUBLE_EQ(Compiled("q*p*abs(p)^0.5").at(0.0, 2.0)[1], 0.0);
}

/// Blocks of 8, 4, 2 and 1 points compute the same; where exponents differ, powers are called for each.
TEST(ExpressionTape, TreatsPointsIndependently) {
  for (const auto& text : expressions) {
    Compiled compiled(text);
    for (const Eigen::Index count : {1, 7, 33, 64}) {
      const Eigen::ArrayXd p = Eigen::ArrayXd::LinSpaced(count, 0.31, 2.3),
                           q = Eigen::ArrayXd::LinSpaced(count, 1.9, 0.4);
      const Eigen::ArrayX3d together = compiled.at(p, q);
      for (Eigen::Index i = 0; i < count; ++i)
        for (Eigen::Index j = 0; j < 3; ++j) {
          const double alone = compiled.at(p[i], q[i])[j];
          EXPECT_NEAR(together(i, j), alone, 1e-14 * (1.0 + std::abs(alone))) << text << ", point " << i;
        }
    }
  }
}

TEST(ExpressionTape, RaisesToWholePowers) {
  for (int n = -5; n <= 17; ++n) {
    const std::string power = std::to_string(n);
    for (const double p : {-1.7, 0.6, 0.0}) {
      const Eigen::Array3d constant = Compiled("p^(" + power + ")").at(p, 0.0), variable = Compiled("p^q").at(p, n);
      const double expected = std::pow(p, n), slope = n == 0 ? 0.0 : n * std::pow(p, n - 1);
      for (const auto& found : {constant, variable}) {
        EXPECT_DOUBLE_EQ(found[0], expected) << p << "^" << n;
        EXPECT_DOUBLE_EQ(found[1], slope) << p << "^" << n;
      }
    }
  }
}

/// Instructions of a program, without its end.
std::size_t length(const std::string& text, std::vector<int> (*targets)(ExpressionTape&, int)) {
  ExpressionTape tape;
  tape.add_variable("p");
  tape.add_variable("q");
  const int out = tape.compile(text);
  const std::vector<int> values = targets(tape, out);
  std::vector<char> known;
  return ProgramMaker(tape, 2).make(values, known).size() - 1;
}

TEST(ExpressionTape, ComputesACommonPartOnce) {
  const auto itself = [](ExpressionTape&, int out) { return std::vector{out}; };
  EXPECT_EQ(length("sin(p*q) + sin(q*p)", itself), 3U);  // product, sine, sum
  EXPECT_EQ(length("2*3*p", itself), 1U);
  EXPECT_EQ(length("2*p + 3*q", itself), 1U);
  EXPECT_EQ(length("p/(1 + q)", itself), 2U);
}

TEST(ExpressionTape, ConstantDerivativesAreNotComputed) {
  const auto slopes = [](ExpressionTape& tape, int out) { return differentiate(tape, out, {0, 1}); };
  EXPECT_EQ(length("2*p + 3*q", slopes), 0U);
  EXPECT_EQ(length("p^2 + q", slopes), 1U);
}

std::vector<LawQuantity> named(const std::vector<std::string>& names) {
  std::vector<LawQuantity> quantities;
  for (const auto& name : names) quantities.push_back({name});
  return quantities;
}

std::string refusal(const ExpressionLawOptions& options) {
  try {
    (void)expression_law(options);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ExpressionLaw, SubExpressionsAndTheForceInARateAreTheSameAsWrittenOut) {
  const auto parameters = named({"k", "c", "e"});
  LawBench short_form({"",
                       expression_law({.force = "spring + c*v",
                                       .parameters = parameters,
                                       .states = {{{"y"}, "e*f"}},
                                       .lets = {{"gap", "x - y"}, {"spring", "k*gap"}}}),
                       {5e3, 20.0, 0.01}});
  LawBench long_form(
      {"",
       expression_law(
           {.force = "k*(x - y) + c*v", .parameters = parameters, .states = {{{"y"}, "e*(k*(x - y) + c*v)"}}}),
       {5e3, 20.0, 0.01}});
  for (int i = 1; i <= 100; ++i) {
    const double d = 1e-3 * std::sin(0.1 * i), v = 0.1 * std::cos(0.1 * i);
    EXPECT_DOUBLE_EQ(short_form.step(1e-3, d, v), long_form.step(1e-3, d, v));
  }
}

/// u' = eta (w - u) with w linear in time has the solution w - w'/eta (1 - exp(-eta t)) for u(0) = w(0).
TEST(ExpressionLaw, AStateLagsOnASignal) {
  const auto law = expression_law({.force = "b*u + 0*x",
                                   .parameters = named({"b", "eta"}),
                                   .states = {{{"u"}, "eta*(w - u)"}},
                                   .signals = named({"w"})});
  const double eta = 50.0, slope = 3.0, step = 1e-3;
  Eigen::ArrayXXd parameters(1, 2), begin(1, 1), end(1, 1), begin_states = Eigen::ArrayXXd::Zero(1, 1), states(1, 1);
  parameters << 2.0, eta;
  Eigen::ArrayXd zero = Eigen::ArrayXd::Zero(1), force(1), stiffness(1), damping(1), inertance(1);
  for (int i = 0; i < 100; ++i) {
    begin(0, 0) = slope * step * i;
    end(0, 0) = slope * step * (i + 1);
    const LawSignals at_begin(begin.data(), 1, 1, Eigen::OuterStride<>(1)),
        at_end(end.data(), 1, 1, Eigen::OuterStride<>(1));
    law->respond({step, parameters, zero, zero, begin_states, zero, zero, zero, at_begin, at_end},
                 {force, stiffness, damping, inertance, states});
    begin_states = states;
  }
  const double t = 100 * step, exact = slope * t - slope / eta * (1.0 - std::exp(-eta * t));
  EXPECT_NEAR(states(0, 0), exact, 1e-5);  // of second order in eta h = 0.05
  EXPECT_DOUBLE_EQ(force[0], 2.0 * states(0, 0));
}

TEST(ExpressionLaw, RefusesAnAccelerationInARateByWhateverWay) {
  EXPECT_NE(
      refusal({.force = "m*a + z", .parameters = named({"m"}), .states = {{{"z"}, "v - f"}}}).find("depends on a"),
      std::string::npos);
  EXPECT_NE(
      refusal({.force = "m*a + z", .parameters = named({"m"}), .states = {{{"z"}, "v - q"}}, .lets = {{"q", "2*a"}}})
          .find("depends on a"),
      std::string::npos);
  EXPECT_EQ(refusal({.force = "m*a + z", .parameters = named({"m"}), .states = {{{"z"}, "v - z"}}}), "accepted");
}

TEST(ExpressionLaw, NamesWhatIsWrongInSubExpressionsAndSignals) {
  EXPECT_NE(refusal({.force = "q*x", .parameters = {}, .lets = {{"q", "2*r"}, {"r", "3"}}}).find("'q'"),
            std::string::npos);  // r stands below q
  EXPECT_NE(refusal({.force = "x", .parameters = {}, .signals = named({"volt"})}).find("'volt' appears in no"),
            std::string::npos);
  EXPECT_NE(refusal({.force = "x + v", .parameters = {}, .signals = named({"v"})}).find("such as volt"),
            std::string::npos);
  EXPECT_NE(refusal({.force = "x*vlt", .parameters = {}, .signals = named({"volt"})}).find("did you mean 'volt'"),
            std::string::npos);
}

}  // namespace
}  // namespace kalfem
