#include "kalfem/system/laws/expression_tape.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include <muParser.h>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/laws/expression_law.hpp"
#include "system/law_bench.hpp"

namespace kalfem {
namespace {

/// An expression of p and q on a tape, with its derivatives by both.
struct Compiled {
  explicit Compiled(const std::string& text) {
    p = tape.add_variable("p");
    q = tape.add_variable("q");
    out = tape.compile(text);
    std::vector<char> known(static_cast<std::size_t>(tape.size()), 0);
    steps = tape.steps_to({out}, known);
    back = tape.steps_back(out, {p, q});
  }

  double value(double at_p, double at_q) {
    values.assign(static_cast<std::size_t>(tape.size()), TapeLanes<4>::Zero());
    for (const auto& [number, constant] : tape.constants()) values[static_cast<std::size_t>(number)] = constant;
    values[static_cast<std::size_t>(p)] = at_p;
    values[static_cast<std::size_t>(q)] = at_q;
    run<4>(steps, values.data());
    return values[static_cast<std::size_t>(out)][2];
  }
  std::pair<double, double> slopes() {
    std::vector<TapeLanes<4>, Eigen::aligned_allocator<TapeLanes<4>>> adjoints(values.size(), TapeLanes<4>::Zero());
    adjoints[static_cast<std::size_t>(out)] = 1.0;
    run_back<4>(back, values.data(), adjoints.data());
    return {adjoints[static_cast<std::size_t>(p)][1], adjoints[static_cast<std::size_t>(q)][3]};
  }

  ExpressionTape tape;
  int p = 0, q = 0, out = 0;
  std::vector<TapeStep> steps, back;
  std::vector<TapeLanes<4>, Eigen::aligned_allocator<TapeLanes<4>>> values;
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
      (void)compiled.value(p, q);
      const auto [slope_p, slope_q] = compiled.slopes();
      EXPECT_NEAR(slope_p, by_p, 2e-8 * (1.0 + std::abs(by_p))) << text;
      EXPECT_NEAR(slope_q, by_q, 2e-8 * (1.0 + std::abs(by_q))) << text;
    }
  }
}

TEST(ExpressionTape, LeavesNoTraceOfABranchThatIsNotTaken) {
  Compiled compiled("p > 0 ? sqrt(p) : 3*p");
  EXPECT_DOUBLE_EQ(compiled.value(-1.0, 0.0), -3.0);
  EXPECT_DOUBLE_EQ(compiled.slopes().first, 3.0);
}

TEST(ExpressionTape, ComputesACommonPartOnce) {
  EXPECT_EQ(Compiled("sin(p*q) + sin(p*q)").steps.size(), 3U);  // product, sine, sum
  EXPECT_EQ(Compiled("2*3*p").steps.size(), 1U);
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
