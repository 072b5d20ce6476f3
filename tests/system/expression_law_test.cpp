// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/laws/expression_law.hpp"
#include "kalfem/system/laws/law_library.hpp"
#include "system/law_bench.hpp"

namespace kalfem {
namespace {

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

void expect_in(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in: " << text;
}

TEST(ExpressionLaw, EqualsTheSaturatingLaw) {
  const auto law = expression_law({.force = "k*x + mu_k1*x/(mu_k2 + abs(x)) + c*v + mu_c1*v/(mu_c2 + abs(v))",
                                   .parameters = named({"k", "mu_k1", "mu_k2", "c", "mu_c1", "mu_c2"})});
  const std::vector<double> parameters{5e3, 20.0, 2e-3, 10.0, 10.0, 0.05};
  LawBench mine({"", law, parameters}), built_in({"", saturating_law(), parameters});
  for (double d = -5e-3; d < 5e-3; d += 3.1e-4) {
    const double v = 20.0 * d + 0.03;
    EXPECT_NEAR(mine.step(1e-3, d, v), built_in.step(1e-3, d, v), 1e-14 * 60.0);  // rounding
    // derivatives by differences
    EXPECT_NEAR(mine.stiffness[0], built_in.stiffness[0], 1e-9 * 15e3);
    EXPECT_NEAR(mine.damping[0], built_in.damping[0], 2e-8 * 210.0);
  }
}

TEST(ExpressionLaw, FollowsTheBoucWenLaw) {
  const auto law = expression_law({.force = "alpha*k*x + (1 - alpha)*k*z + c*v",
                                   .parameters = named({"k", "alpha", "A", "beta", "gamma", "n", "c"}),
                                   .states = {{{"z"}, "A*v - beta*abs(v)*abs(z)^(n-1)*z - gamma*v*abs(z)^n"}}});
  const std::vector<double> parameters{4e4, 0.1, 1.0, 2e6, 1e6, 2.0, 3.0};
  LawBench mine({"", law, parameters}), built_in({"", bouc_wen_law(), parameters});
  const double amplitude = 1e-3, w = 40.0, h = 1e-4;
  mine.begin_rate = built_in.begin_rate = amplitude * w;
  for (int i = 1; i <= 3000; ++i) {
    const double d = amplitude * std::sin(w * i * h), v = amplitude * w * std::cos(w * i * h);
    // One integrates along time, the other along the deformation: both of second order, (w h)^2 = 1.6e-5.
    const double found = mine.step(h, d, v), expected = built_in.step(h, d, v);
    EXPECT_NEAR(found, expected, 2e-4 * 25.0);
  }
}

TEST(ExpressionLaw, CoupledStatesKeepALinearSystemsSolution) {
  // A Maxwell pair written as two coupled states; with the motion at rest they turn as an oscillator of 2 rad/s.
  const auto law = expression_law(
      {.force = "p + w*q + 0*x*v", .parameters = named({"w"}), .states = {{{"p"}, "w*q"}, {{"q"}, "-w*p"}}});
  LawBench bench({"", law, {2.0}});
  bench.begin_states << 1.0, 0.0;
  for (int i = 0; i < 1000; ++i) bench.step(1e-3, 0.0, 0.0);
  // second order in h: found 3e-7
  EXPECT_NEAR(bench.states(0, 0), std::cos(2.0), 1e-6);
  EXPECT_NEAR(bench.states(0, 1), -std::sin(2.0), 1e-6);
}

TEST(ExpressionLaw, UsesTheAcceleration) {
  LawBench bench({"", expression_law({.force = "b*a", .parameters = named({"b"})}), {3.0}});
  EXPECT_DOUBLE_EQ(bench.step(1e-3, 0.0, 0.0, 5.0), 15.0);
  // found 5e-12: a difference of a linear law
  EXPECT_NEAR(bench.inertance[0], 3.0, 1e-10);
}

TEST(ExpressionLaw, NamesWhatIsWrong) {
  expect_in(refusal({.force = "k*x + stif*v", .parameters = named({"k", "stiff"})}), "did you mean 'stiff'");
  expect_in(refusal({.force = "k*x + stif*v", .parameters = named({"k", "stiff"})}), "position 6");
  expect_in(refusal({.force = "k*(x", .parameters = named({"k"})}), "Missing parenthesis");
  expect_in(refusal({.force = "", .parameters = {}}), "empty");
  expect_in(refusal({.force = "k*x, 3", .parameters = named({"k"})}), "several results");
  expect_in(refusal({.force = "k = 3", .parameters = named({"k"})}), "would assign to a variable");
  expect_in(refusal({.force = "\"k\"", .parameters = {}}), "Strings");
  expect_in(refusal({.force = "k*x", .parameters = named({"k", "c"})}), "'c' appears in no expression");
  expect_in(refusal({.force = "k*x*z", .parameters = named({"k"}), .states = {{{"z"}, "a - z"}}}), "\"a\"");
}

TEST(ExpressionLaw, RefusesNamesThatClash) {
  expect_in(refusal({.force = "x", .parameters = named({"x"})}), "'x'");
  expect_in(refusal({.force = "sin*x", .parameters = named({"sin"})}), "name of a function");
  expect_in(refusal({.force = "_pi*x", .parameters = named({"_pi"})}), "name of a constant");
  expect_in(refusal({.force = "k*x", .parameters = named({"k", "k"})}), "used twice");
  expect_in(refusal({.force = "k*x", .parameters = named({"2k"})}), "letters, digits");
  expect_in(refusal({.force = "x", .parameters = named({""})}), "letters, digits");
  expect_in(refusal({.force = "z", .parameters = named({"z"}), .states = {{{"z"}, "v"}}}), "used twice");
}

TEST(ExpressionLaw, ReportsSeveralMistakesTogether) {
  const auto text = refusal({.force = "k*", .parameters = named({"k"}), .states = {{{"z"}, "v +"}}});
  expect_in(text, "the force");
  expect_in(text, "the rate of 'z'");
}

TEST(ExpressionLaw, ComparisonsAreNotAssignments) {
  EXPECT_EQ(refusal({.force = "x >= 0 ? k*x : (x == -1 ? 0 : (x != 3 ? 0 : k))", .parameters = named({"k"})}),
            "accepted");
}

TEST(ExpressionLaw, NonFiniteResultsAreNaNForces) {
  LawBench bench({"", expression_law({.force = "sqrt(x) + c*v", .parameters = named({"c"})}), {1.0}});
  EXPECT_TRUE(std::isnan(bench.step(1e-3, -1.0, 0.0)));
  EXPECT_DOUBLE_EQ(bench.step(1e-3, 4.0, 0.0), 2.0);
  LawBench growing(
      {"", expression_law({.force = "z + c*x", .parameters = named({"c"}), .states = {{{"z"}, "1 + z^2"}}}), {1.0}});
  EXPECT_TRUE(std::isnan(growing.step(100.0, 0.0, 0.0)));  // z = tan(t) has no value there
}

TEST(ExpressionLaw, IsSafeToShareBetweenThreads) {
  const auto law = expression_law({.force = "k*x + z", .parameters = named({"k"}), .states = {{{"z"}, "v - 5*z"}}});
  const auto work = [&](double k) {
    LawBench bench({"", law, {k}}, 20);
    double sum = 0.0;
    for (int i = 1; i <= 200; ++i) sum += bench.step(1e-3, 1e-3 * std::sin(0.1 * i), 0.1 * std::cos(0.1 * i));
    return sum;
  };
  std::vector<double> alone(4), together(4);
  for (std::size_t t = 0; t < 4; ++t) alone[t] = work(1e3 * static_cast<double>(t + 1));
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] { together[t] = work(1e3 * static_cast<double>(t + 1)); });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(alone, together);
}

}  // namespace
}  // namespace kalfem
