// SPDX-License-Identifier: Apache-2.0
// Cost of a law that is written as an expression, as a ratio to the compiled law of the same form: force, tangents and
// states at the sigma points of a filter, medians of alternating repetitions in one run.
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/system/laws/law_library.hpp"
#include "timing.hpp"

namespace {

using namespace kalfem;
using namespace kalfem::benchmarks;
using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;

/// A compiled law and the expression of the same force; both take the same parameters in the same order.
struct Pair {
  std::string law;
  std::vector<std::pair<std::string, double>> parameters;
  std::string force;
  std::vector<ExpressionState> states = {};
};

const std::vector<Pair>& pairs() {
  static const std::vector<Pair> all = {
      {"linear", {{"k", 5e3}, {"c", 10.0}}, "k*x + c*v"},
      {"cubic", {{"k", 5e3}, {"k3", 1e9}, {"c", 10.0}, {"c3", 3.0}}, "k*x + k3*x^3 + c*v + c3*v^3"},
      {"saturating",
       {{"k", 5e3}, {"mu_k1", 20.0}, {"mu_k2", 2e-3}, {"c", 10.0}, {"mu_c1", 10.0}, {"mu_c2", 0.05}},
       "k*x + mu_k1*x/(mu_k2 + abs(x)) + c*v + mu_c1*v/(mu_c2 + abs(v))"},
      {"coulomb", {{"f_c", 12.0}, {"v_ref", 5e-3}, {"k", 1e3}, {"c", 2.0}}, "k*x + c*v + f_c*tanh(v/v_ref)"},
      {"stribeck",
       {{"f_c", 12.0}, {"f_s", 18.0}, {"v_s", 0.05}, {"v_ref", 5e-3}, {"k", 1e3}, {"c", 2.0}},
       "k*x + c*v + (f_c + (f_s - f_c)*exp(-(v/v_s)^2))*tanh(v/v_ref)"},
      {"bouc_wen",
       {{"k", 1e4}, {"alpha", 0.2}, {"A", 1.0}, {"beta", 300.0}, {"gamma", 200.0}, {"n", 1.0}, {"c", 5.0}},
       "alpha*k*x + (1 - alpha)*k*z + c*v",
       {{{"z", "m", "hysteretic deformation"}, "A*v - beta*abs(v)*abs(z)^(n - 1)*z - gamma*v*abs(z)^n"}}},
  };
  return all;
}

/// Everything that one connector is evaluated with.
class Bench {
public:
  Bench(ConnectorLawPtr law, const Pair& pair, Index points) : law_(std::move(law)) {
    const auto states = static_cast<Index>(law_->states().size());
    parameters_.resize(points, std::ssize(law_->parameters()));
    for (Index j = 0; j < parameters_.cols(); ++j)
      for (const auto& [name, value] : pair.parameters)
        if (law_->parameters()[static_cast<std::size_t>(j)].name == name) parameters_.col(j) = value;
    begin_deformation_ = ArrayXd::LinSpaced(points, -3e-3, 3e-3);
    begin_rate_ = ArrayXd::LinSpaced(points, 0.1, -0.1);
    deformation_ = begin_deformation_ + 1e-3 * begin_rate_;
    rate_ = begin_rate_ + 1e-3;
    acceleration_ = ArrayXd::Constant(points, 1.0);
    begin_states_ = states_ = ArrayXXd::Constant(points, states, 1e-4);
    force_ = stiffness_ = damping_ = inertance_ = ArrayXd::Zero(points);
  }

  double respond(int times) {
    for (int i = 0; i < times; ++i)
      law_->respond(
          {1e-3, parameters_, begin_deformation_, begin_rate_, begin_states_, deformation_, rate_, acceleration_},
          {force_, stiffness_, damping_, inertance_, states_});
    return force_.sum();
  }

  [[nodiscard]] const ArrayXd& force() const { return force_; }

private:
  ConnectorLawPtr law_;
  ArrayXXd parameters_, begin_states_, states_;
  ArrayXd begin_deformation_, begin_rate_, deformation_, rate_, acceleration_, force_, stiffness_, damping_, inertance_;
};

void compare(const Pair& pair, Index points) {
  std::vector<LawQuantity> parameters;
  for (const auto& [name, value] : pair.parameters) parameters.push_back({.name = name});
  Bench compiled(make_law(pair.law), pair, points);
  Bench written(make_law("expression", {.parameters = parameters, .force = pair.force, .states = pair.states}), pair,
                points);
  const int times = 20'000;
  std::vector<double> of_compiled, of_written;
  for (int repetition = 0; repetition < 15; ++repetition) {
    of_compiled.push_back(seconds([&] { return compiled.respond(times); }) / times);
    of_written.push_back(seconds([&] { return written.respond(times); }) / times);
  }
  const double apart = (compiled.force() - written.force()).abs().maxCoeff() / compiled.force().abs().maxCoeff();
  std::printf("%-12s %6td %12.1f %12.1f %10.2f %12.1e\n", pair.law.c_str(), points, 1e9 * median(of_compiled),
              1e9 * median(of_written), median(of_written) / median(of_compiled), apart);
}

}  // namespace

int main() {
  std::printf("%-12s %6s %12s %12s %10s %12s\n", "law", "points", "compiled[ns]", "written[ns]", "ratio",
              "forces apart");
  for (const auto& pair : pairs())
    for (const Index points : {Index{7}, Index{17}, Index{33}}) compare(pair, points);
}
