// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/law_terms.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double prior_of_law = 0.3;  ///< of each further term, relative to the connector's force

constexpr double farther = 20.0;  ///< than its first guesses a place is not sought

/// Parts of the largest deformation at which a stop is tried first.
std::vector<double> places(double largest) { return {0.35 * largest, 0.55 * largest, 0.75 * largest}; }

ExpressionState state(const std::string& rate) {
  const LawQuantity z{"z", "m", "of the further term"};
  return {z, rate};
}

void add_stops(const ConnectorMotion& motion, double force, std::vector<LawTerm>& terms) {
  const double upper = motion.largest_deformation, lower = -motion.least_deformation;
  const auto stop = [&](bool above, double reach) {
    terms.push_back({.name = above ? "upper stop" : "lower stop",
                     .force = above ? "K*max(0, x - s)" : "-K*max(0, -x - s)",
                     .unit = "N/m",
                     .deviation = force / (0.25 * reach),
                     .starts = places(reach),
                     .unit_of_place = "m",
                     .words = above ? "a stop beyond a deformation of" : "a stop below a deformation of -",
                     .laws = "gap or hunt_crossley"});
  };
  if (upper > 0.0) stop(true, upper);
  if (lower > 0.0) stop(false, lower);
}

/// The force as a connector between the same points, with its unknown.
void add_term(const ConnectorDescription& connector, const LawTerm& term, double place, FurtherForces& forces) {
  const std::string name = fmt::format("{} ({})", connector.name, term.name);
  ExpressionLawOptions options{.force = term.force, .parameters = {{"K", term.unit}}, .states = term.states};
  VectorXd values = VectorXd::Zero(term.searched() ? 2 : 1);
  if (term.searched()) {
    options.parameters.push_back({"s", term.unit_of_place});
    values[1] = place;
  }
  forces.connectors.push_back({name, connector.from, connector.to, expression_law(options), values});
  forces.unknowns.push_back({.name = name + ".K",
                             .targets = {{name + ".K", name, term.unit, 0.0, ConnectorParameter{0}}},
                             .deviation = term.deviation});
}

std::string in_words(const LawTerm& term, double place, double coefficient) {
  std::string text = term.words;
  if (term.searched()) text += fmt::format("{}{:.3g} {}", text.ends_with('-') ? "" : " ", place, term.unit_of_place);
  return text + fmt::format(" ({:.3g} {})", coefficient, term.unit);
}

LackingForce lacking_force(const ConnectorDescription& connector, const ChosenTerm& chosen, double coefficient) {
  const LawTerm& term = chosen.term;
  LackingForce lacking{.name = connector.name + "_" + term.name,
                       .from = connector.from,
                       .to = connector.to,
                       .force = term.force,
                       .factor = coefficient,
                       .deviation = term.deviation};
  std::ranges::replace(lacking.name, ' ', '_');
  for (const auto& state : term.states) lacking.states.emplace_back(state.quantity.name, state.rate);
  if (term.searched()) lacking.place = chosen.place;
  return lacking;
}

}  // namespace

std::vector<LawTerm> law_terms(const ConnectorMotion& motion) {
  const double d = motion.deformation, v = motion.rate, force = prior_of_law * motion.force, time = d / v;
  std::vector<LawTerm> terms{
      {.name = "asymmetric damping",
       .force = "K*abs(v)/(1 + abs(v)/s)",
       .unit = "N s/m",
       .deviation = force / v,
       .starts = {v, 10.0 * v},
       .unit_of_place = "m/s",
       .words = "damping that is another one in rebound than in compression, plus and minus, half of it left at",
       .laws = "damper"},
      {.name = "cubic stiffness",
       .force = "K*x^3",
       .unit = "N/m^3",
       .deviation = force / (3.0 * d * d * d),
       .words = "a force cubic in its deformation",
       .laws = "cubic"},
      {.name = "quadratic stiffness",
       .force = "K*x^2",
       .unit = "N/m^2",
       .deviation = force / (d * d),
       .words = "a force quadratic in its deformation",
       .laws = "polynomial"},
      {.name = "friction",
       .force = fmt::format("K*tanh(v/{:.17g})", 0.1 * v),
       .unit = "N",
       .deviation = force,
       .words = "friction",
       .laws = "coulomb or jenkins"},
      {.name = "digressive damping",
       .force = "K*v/(1 + abs(v)/s)",
       .unit = "N s/m",
       .deviation = force / v,
       .starts = {v, 5.0 * v},
       .unit_of_place = "m/s",
       .words = "damping that depends on the rate, half of it left at",
       .laws = "damper"},
      {.name = "cubic damping",
       .force = "K*v^3",
       .unit = "N s^3/m^3",
       .deviation = force / (3.0 * v * v * v),
       .words = "a force cubic in its rate",
       .laws = "cubic"},
      {.name = "hysteresis",
       .force = "K*z",
       .states = {state("v - abs(v)*z/s")},
       .unit = "N/m",
       .deviation = force / d,
       .starts = {0.3 * d, 1.0 * d},
       .unit_of_place = "m",
       .words = "hysteresis that yields at about",
       .laws = "bouc_wen, bilinear or jenkins"},
      {.name = "lag",
       .force = "K*(x - z)",
       .states = {state("(x - z)/s")},
       .unit = "N/m",
       .deviation = force / d,
       .starts = {0.3 * time, 3.0 * time},
       .unit_of_place = "s",
       .words = "a force that lags behind (a spring in series with a dashpot), relaxing in",
       .laws = "an expression with a state"},
  };
  add_stops(motion, force, terms);
  for (auto& term : terms) {
    term.least = term.starts.front() / farther;
    term.most = term.starts.back() * farther;
  }
  return terms;
}

Hypothesis lacking_terms(const DiagnosisInput& input, const ConnectorDescription& connector,
                         const std::vector<ChosenTerm>& terms, std::size_t searched) {
  const auto first = static_cast<Index>(input.problem->settings.unknowns.size());
  const LawTerm& sought = terms[searched].term;
  int fitted = 0;
  std::vector<std::string> laws;
  for (const auto& [term, place] : terms) {
    fitted += term.searched() ? 2 : 1;
    if (std::ranges::find(laws, term.laws) == laws.end()) laws.push_back(term.laws);
  }
  const auto at = [terms, searched](double place) {
    auto chosen = terms;
    chosen[searched].place = place;
    return chosen;
  };
  return {
      .code = "wrong_law",
      .subject = connector.name,
      .starts = sought.starts,
      .search = sought.searched() ? Search::factor : Search::none,
      .step = 0.15,
      .fitted = fitted,
      .correct =
          [connector, at, sought](const DiagnosisInput& given, double place) {
            if (sought.searched() && (place < sought.least || place > sought.most))
              throw InvalidInput("the number of a further force", "it is beyond what the record shows", "");
            FurtherForces further;
            for (const auto& [term, value] : at(place)) add_term(connector, term, value, further);
            return with_forces(given, further);
          },
      .words =
          [connector, at, first](double place, const VectorXd& estimates) {
            const auto chosen = at(place);
            std::string text = fmt::format("connector '{}' does not follow its law '{}': the record asks for ",
                                           connector.name, connector.law->name());
            for (std::size_t i = 0; i < chosen.size(); ++i)
              text += (i == 0                   ? ""
                       : i + 1 == chosen.size() ? " and "
                                                : ", ") +
                      in_words(chosen[i].term, chosen[i].place, estimates[first + static_cast<Index>(i)]);
            return text;
          },
      .remedy = fmt::format("try another law for '{}', such as {}", connector.name, fmt::join(laws, ", and ")),
      .forces =
          [connector, at, first](double place, const VectorXd& estimates) {
            std::vector<LackingForce> forces;
            for (const auto& chosen : at(place))
              forces.push_back(lacking_force(connector, chosen, estimates[first + static_cast<Index>(forces.size())]));
            return forces;
          }};
}

}  // namespace kalfem
