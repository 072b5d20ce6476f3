// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kalfem/system/laws/law_library.hpp"
#include "system/law_bench.hpp"
#include "system/masing_branches.hpp"

// Laws beside closed forms, which share nothing with the way in which their states are advanced.

namespace kalfem {
namespace {

constexpr double k = 4e4, f_y = 12.0;

LawCase ramberg_osgood(double alpha, double r) { return {"", make_law("ramberg_osgood"), {k, f_y, alpha, r, 0.0}}; }

TEST(RambergOsgood, IsStiffAtRestAsStated) {
  LawBench bench(ramberg_osgood(1.0, 5.0));
  EXPECT_NEAR(bench.step(1e-3, 1e-9, 0.0), k * 1e-9, 1e-12 * k * 1e-9);
  EXPECT_NEAR(bench.stiffness[0], k, 1e-12 * k);
}

/// The tangents are within 2 % of the plastic deformation, which is at most 1 % of the force, and ever less for larger
/// exponents.
TEST(RambergOsgood, FollowsItsBackbone) {
  for (const double r : {2.0, 3.0, 5.0, 12.0})
    for (const double alpha : {3.0 / 7.0, 1.0}) {
      LawBench bench(ramberg_osgood(alpha, r));
      for (double part = 0.01; part < 20.0; part *= 1.1) {  // plastic over elastic deformation
        const double f = f_y * std::pow(part / alpha, 1.0 / (r - 1.0)), d = f / k * (1.0 + part);
        EXPECT_NEAR(bench.step(1e-3, d, 1.0), f, 0.0205 / r * f) << r << " " << alpha << " " << part;
      }
    }
}

/// The area is a difference of two that are larger for small exponents, and so is its error.
TEST(RambergOsgood, DissipatesTheAreaOfMasingsLoop) {
  for (const double r : {2.0, 5.0, 12.0})
    for (const double part : {0.1, 1.0, 10.0}) {
      const double f = f_y * std::pow(part, 1.0 / (r - 1.0)), d = f / k * (1.0 + part);
      const double exact = 4.0 * (r - 1.0) / (r + 1.0) * f_y * f_y / k * std::pow(f / f_y, r + 1.0);
      EXPECT_NEAR(cycle_work(ramberg_osgood(1.0, r), d, 40.0), exact, (r < 3.0 ? 0.05 : 0.03) * exact)
          << r << " " << part;
    }
}

/// Small loops within large ones, which close, and after which a branch goes on as if they had not been. A branch has
/// twice the error of the backbone beside that of its reversal: 3 % for r = 2.
TEST(RambergOsgood, ClosesNestedLoopsByMasingsRules) {
  for (const double r : {2.0, 5.0}) {
    LawBench bench(ramberg_osgood(1.0, r));
    MasingBranches exact(k, f_y, 1.0, r);
    double largest = 0.0, worst = 0.0;
    for (int i = 1; i <= 40000; ++i) {
      const double t = 1e-4 * i;
      const double d = 4e-4 * (std::sin(8.0 * t) + 0.6 * std::sin(37.0 * t) + 0.3 * std::sin(120.0 * t + 1.0) * t);
      const double f = exact.move_to(d);
      largest = std::max(largest, std::abs(f));
      worst = std::max(worst, std::abs(bench.step(1e-4, d, 0.0) - f));
    }
    EXPECT_LT(worst, 0.06 / r * largest) << r;
  }
}

constexpr double k_inf = 3e4, k_1 = 2e4, tau_1 = 3e-3, k_2 = 1e4, tau_2 = 5e-2, k_3 = 5e3, tau_3 = 1.0;

LawCase rubber() {
  LawArguments names;
  for (const char* name : {"k1", "tau1", "k2", "tau2", "k3", "tau3"}) names.parameters.push_back({name});
  return {"", make_law("prony", names), {k_inf, 0.0, k_1, tau_1, k_2, tau_2, k_3, tau_3}};
}

/// Deformed at a constant rate up to d, then held.
TEST(Prony, RelaxesAfterARampAsTheSumOfExponentials) {
  LawBench bench(rubber());
  const double d = 1e-3, rise = 0.02, h = 1e-5;
  for (int i = 1; i <= 2000; ++i) {
    bench.begin_rate = d / rise;
    bench.step(h, d * i / 2000.0, d / rise);
  }
  bench.begin_rate = 0.0;
  for (int i = 1; i <= 20000; ++i) {
    const double t = h * i, f = bench.step(h, d, 0.0);
    if (i % 500 != 0) continue;
    const auto branch = [&](double stiffness, double tau) {
      return stiffness * tau / rise * (1.0 - std::exp(-rise / tau)) * std::exp(-t / tau);
    };
    const double exact = d * (k_inf + branch(k_1, tau_1) + branch(k_2, tau_2) + branch(k_3, tau_3));
    EXPECT_NEAR(f, exact, 1e-6 * exact) << t;
  }
}

/// Over three decades of frequency. The motion is stationary from its begin: z = Im(a exp(i w t) / (1 + i w tau)).
TEST(Prony, HasItsStorageAndLossModulus) {
  const double a = 1e-3;
  constexpr int steps = 4000;
  for (const double w : {1.0, 10.0, 100.0, 1000.0}) {
    LawBench bench(rubber());
    double storage = k_inf, loss = 0.0;
    int branch = 0;
    for (const auto& [stiffness, tau] : {std::pair{k_1, tau_1}, {k_2, tau_2}, {k_3, tau_3}}) {
      const double x = w * tau, share = 1.0 / (1.0 + x * x);
      storage += stiffness * x * x * share;
      loss += stiffness * x * share;
      bench.begin_states(0, branch++) = -a * x * share;
    }
    bench.begin_rate = a * w;
    double in_phase = 0.0, in_quadrature = 0.0;
    for (int i = 1; i <= steps; ++i) {
      const double phase = 2.0 * M_PI * i / steps;
      const double f = bench.step(2.0 * M_PI / w / steps, a * std::sin(phase), a * w * std::cos(phase));
      in_phase += 2.0 / steps * f * std::sin(phase) / a;
      in_quadrature += 2.0 / steps * f * std::cos(phase) / a;
    }
    EXPECT_NEAR(in_phase, storage, 1e-5 * storage) << w;
    EXPECT_NEAR(in_quadrature, loss, 1e-5 * storage) << w;
  }
}

TEST(Prony, TakesItsBranchesFromTheNames) {
  const auto law = make_law("prony", {.parameters = {{"k2"}, {"tau2"}}});
  ASSERT_EQ(law->parameters().size(), 6u);
  EXPECT_EQ(law->parameters()[4].name, "k2");
  EXPECT_EQ(law->states().size(), 2u);
  EXPECT_TRUE(std::isnan(law->parameters()[2].default_value));  // a branch below the highest one is asked for
  EXPECT_THROW((void)make_law("prony"), InvalidInput);
  EXPECT_THROW((void)make_law("prony", {.parameters = {{"k9"}, {"tau9"}}}), InvalidInput);
  EXPECT_THROW((void)prony_law(0), InvalidInput);
}

TEST(Prony, OfOneBranchIsMaxwell) {
  LawBench series({"", prony_law(1), {k_inf, 3.0, k_1, tau_1}}),
      element({"", make_law("maxwell"), {k_1, tau_1, k_inf, 3.0}});
  for (int i = 1; i <= 200; ++i) {
    const double t = 1e-3 * i, d = 1e-3 * std::sin(40.0 * t), v = 0.04 * std::cos(40.0 * t);
    const double f = element.step(1e-3, d, v);
    EXPECT_NEAR(series.step(1e-3, d, v), f, 1e-12 * (std::abs(f) + 1.0));
  }
}

}  // namespace
}  // namespace kalfem
