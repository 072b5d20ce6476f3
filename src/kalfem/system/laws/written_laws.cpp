// SPDX-License-Identifier: Apache-2.0
#include <cassert>
#include <limits>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "kalfem/system/laws/expression_law.hpp"
#include "kalfem/system/laws/law_library.hpp"

namespace kalfem {

// Laws that are written as expressions, with a name and parameters of their own. Their derivatives are exact and their
// states integrated as those of every expression.

namespace {

class WrittenLaw final : public ConnectorLaw {
public:
  WrittenLaw(std::string name, const ExpressionLawOptions& options)
      : name_(std::move(name)), parameters_(options.parameters), law_(expression_law(options)) {}

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] const std::vector<LawQuantity>& parameters() const override { return parameters_; }
  [[nodiscard]] const std::vector<LawQuantity>& states() const override { return law_->states(); }
  [[nodiscard]] bool uses_acceleration() const override { return law_->uses_acceleration(); }
  [[nodiscard]] bool vectorised() const override { return law_->vectorised(); }
  void respond(const LawPoints& points, LawResponse response) const override { law_->respond(points, response); }

private:
  std::string name_;
  std::vector<LawQuantity> parameters_;
  ConnectorLawPtr law_;
};

ConnectorLawPtr written(std::string name, const ExpressionLawOptions& options) {
  return std::make_shared<WrittenLaw>(std::move(name), options);
}

}  // namespace

ConnectorLawPtr degrading_bouc_wen_law() {
  return written(
      "bouc_wen_degrading",
      {.force = "alpha*k*x + (1 - alpha)*k*z + c*v",
       .parameters = {{"k", "N/m", "stiffness at small deformation (for A = 1)", Range::nonnegative},
                      {"alpha", "-", "stiffness after yield over k", Range::fraction, 0.0},
                      {"A", "-", "initial slope of z over d", Range::nonnegative, 1.0},
                      {"beta", "1/m^n", "energy dissipation of the loop", Range::nonnegative},
                      {"gamma", "1/m^n", "shape of the loop: softening > 0, hardening < 0", Range::any},
                      {"n", "-", "sharpness of the transition", Range::at_least_one, 1.0},
                      {"delta_nu", "1/m^2", "degradation of strength with e", Range::nonnegative, 0.0},
                      {"delta_eta", "1/m^2", "degradation of stiffness with e", Range::nonnegative, 0.0},
                      {"zeta_s", "-", "largest part of the slope that pinching takes", Range::fraction, 0.0},
                      {"p", "1/m^2", "growth of pinching with e", Range::nonnegative, 0.0},
                      {"q", "-", "place of pinching, part of z_u", Range::any, 0.0},
                      {"psi", "m", "width of pinching", Range::positive, 1.0},
                      {"delta_psi", "1/m", "growth of that width with e", Range::nonnegative, 0.0},
                      {"lambda", "-", "part of the width that does not grow with zeta_1", Range::positive, 0.5},
                      {"c", "N s/m", "damping alongside", Range::nonnegative, 0.0}},
       .states = {{{"z", "m", "hysteretic deformation"},
                   "h*(A*v - nu*(beta*abs(v)*abs(z)^(n - 1)*z + gamma*v*abs(z)^n))/(1 + delta_eta*lost)"},
                  {{"e", "m^2", "dissipated energy over (1 - alpha) k"}, "z*v"}},
       .lets = {{"lost", "max(e, 0)"},
                {"nu", "1 + delta_nu*lost"},
                {"zeta_1", "zeta_s*(1 - exp(-p*lost))"},
                {"zeta_2", "(psi + delta_psi*lost)*(lambda + zeta_1)"},
                {"z_u", "(A/(nu*abs(beta + gamma) + 1e-300))^(1/n)"},
                {"h", "1 - zeta_1*exp(-((z*sign(v) - q*z_u)/zeta_2)^2)"}}});
}

ConnectorLawPtr maxwell_law() {
  return written("maxwell", {.force = "k*x + c*v + k_branch*(x - z)",
                             .parameters = {{"k_branch", "N/m", "stiffness of the spring in series", Range::positive},
                                            {"tau", "s", "relaxation time, dashpot over spring", Range::positive},
                                            {"k", "N/m", "stiffness alongside", Range::nonnegative, 0.0},
                                            {"c", "N s/m", "damping alongside", Range::nonnegative, 0.0}},
                             .states = {{{"z", "m", "deformation of the dashpot in series"}, "(x - z)/tau"}}});
}

ConnectorLawPtr prony_law(int branches) {
  if (branches < 1 || branches > max_internal_states)
    throw InvalidInput(fmt::format("prony: the number of branches is {}", branches),
                       fmt::format("it must lie between 1 and {}", max_internal_states),
                       "name the parameters of each branch, such as k1, tau1, k2, tau2");
  ExpressionLawOptions options{.force = "k_inf*x + c*v",
                               .parameters = {{"k_inf", "N/m", "stiffness after a long time", Range::nonnegative, 0.0},
                                              {"c", "N s/m", "damping alongside", Range::nonnegative, 0.0}}};
  for (int i = 1; i <= branches; ++i) {
    options.force += fmt::format(" + k{0}*(x - z{0})", i);
    options.parameters.push_back({fmt::format("k{}", i), "N/m", "stiffness that relaxes", Range::positive});
    options.parameters.push_back({fmt::format("tau{}", i), "s", "time in which it relaxes", Range::positive});
    options.states.push_back(
        {{fmt::format("z{}", i), "m", "deformation of a dashpot"}, fmt::format("(x - z{0})/tau{0}", i)});
  }
  return written("prony", options);
}

ConnectorLawPtr lugre_law() {
  return written("lugre", {.force = "k*x + sigma_0*z + sigma_1*(v - slip) + sigma_2*v",
                           .parameters = {{"sigma_0", "N/m", "stiffness of the bristles", Range::positive},
                                          {"f_c", "N", "sliding friction", Range::positive},
                                          {"f_s", "N", "static friction", Range::positive},
                                          {"v_s", "m/s", "rate of the change between them", Range::positive},
                                          {"sigma_1", "N s/m", "damping of the bristles", Range::nonnegative, 0.0},
                                          {"sigma_2", "N s/m", "damping alongside", Range::nonnegative, 0.0},
                                          {"k", "N/m", "stiffness alongside", Range::nonnegative, 0.0}},
                           .states = {{{"z", "m", "deflection of the bristles"}, "v - slip"}},
                           .lets = {{"g", "f_c + (f_s - f_c)*exp(-(v/v_s)^2)"}, {"slip", "sigma_0*abs(v)*z/g"}}});
}

}  // namespace kalfem
