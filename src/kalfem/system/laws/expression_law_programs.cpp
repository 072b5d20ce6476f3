// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/expression_law_programs.hpp"

#include "kalfem/system/laws/expression_derivatives.hpp"

namespace kalfem {
namespace {

using Values = std::vector<int>;

void append(Values& to, const Values& values) { to.insert(to.end(), values.begin(), values.end()); }

/// The numbers on the tape of all that a law computes.
struct Wanted {
  explicit Wanted(CompiledExpressions& at) {
    auto& tape = at.tape;
    Values motion_and_states{at.x, at.v, at.a};
    append(motion_and_states, at.states);
    force = differentiate(tape, at.force, motion_and_states);
    force.insert(force.begin(), at.force);
    Values by_deformation, by_rate;
    for (const int rate : at.rates) {
      const auto slopes = differentiate(tape, rate, motion_and_states);
      by_deformation.push_back(slopes[0]);
      by_rate.push_back(slopes[1]);
      by_state.insert(by_state.end(), slopes.begin() + 3, slopes.end());
    }
    tangents = by_deformation;
    append(tangents, by_rate);
  }

  Values force;     ///< f and its derivatives by x, v, a and the states
  Values by_state;  ///< dg/ds, row by row
  Values tangents;  ///< dg/dx, then dg/dv
};

bool depend(const ExpressionTape& tape, const Values& values, const Values& variables) {
  const auto active = tape.that_depend_on(variables);
  for (const int value : values)
    if (active[static_cast<std::size_t>(value)] != 0) return true;
  return false;
}

}  // namespace

LawPrograms::LawPrograms(const ExpressionLawOptions& options)
    : at(options),
      variable_count(static_cast<int>(3 + at.parameters.size() + at.states.size() + at.signals.size())),
      uses_acceleration(at.tape.depends(at.force, at.a)) {
  const Wanted wanted(at);
  ProgramMaker maker(at.tape, variable_count);
  ExpressionProgram copies;
  for (int i = 0; i < answer_count; ++i) maker.answer(wanted.force[static_cast<std::size_t>(i)], i, copies);

  Values of_rates = at.rates, moving{at.x, at.v, at.a};
  append(of_rates, wanted.by_state);
  Values of_states = of_rates;
  append(of_states, wanted.tangents);
  Values all = wanted.force;
  append(all, of_states);
  append(moving, at.states);
  append(moving, at.signals);

  std::vector<char> known;
  of_parameters = maker.make(maker.needed_before(all, at.tape.that_depend_on(moving)), known);
  auto known_by_rates = known;
  rates.of_motion = maker.make(maker.needed_before(of_states, at.tape.that_depend_on(at.states)), known_by_rates);
  rates.rates = maker.make(of_rates, known_by_rates);
  rates.tangents = maker.make(wanted.tangents, known_by_rates);
  rates.rate = maker.full_places(at.rates, rates.rates);
  rates.by_state = maker.full_places(wanted.by_state, rates.rates);
  const auto tangents = maker.full_places(wanted.tangents, rates.tangents);
  of_force = maker.make(wanted.force, known);
  of_force.insert(of_force.end() - 1, copies.begin(), copies.end());  // before the end

  const auto states = static_cast<std::ptrdiff_t>(at.states.size());
  rates.by_deformation.assign(tangents.begin(), tangents.begin() + states);
  rates.by_rate.assign(tangents.begin() + states, tangents.end());
  for (auto value = wanted.force.begin() + answer_count; value != wanted.force.end(); ++value)
    force_by_state.push_back(maker.place(*value));
  rates.deformation = at.x;
  rates.motion_rate = at.v;
  rates.states = at.states;
  rates.signals = at.signals;
  rates.linear = !depend(at.tape, wanted.by_state, at.states);
  constants = maker.constants();
  result_count = maker.result_count();
}

}  // namespace kalfem
