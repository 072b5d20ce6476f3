// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/expression_program.hpp"

#include <utility>

namespace kalfem {

using enum TapeOperation;

namespace {

constexpr auto rows = static_cast<int>(points_together);

std::size_t at(int value) { return static_cast<std::size_t>(value); }

}  // namespace

ProgramMaker::ProgramMaker(const ExpressionTape& tape, int variables)
    : tape_(tape), variables_(variables), places_(at(tape.size()), Place{-1, 0}) {
  for (int value = 0; value < tape.size(); ++value) {
    if (tape[value].kind == TapeValue::Kind::variable) places_[at(value)] = {first_variable_base + value, 0};
    if (tape[value].kind != TapeValue::Kind::constant) continue;
    places_[at(value)] = {constants_base, static_cast<int>(constants_.size())};
    constants_.insert(constants_.end(), at(rows), tape[value].constant);
  }
}

void ProgramMaker::answer(int value, int answer, ExpressionProgram& copies) {
  const Place column{first_variable_base + variables_ + answer, 0};
  if (places_[at(value)].base < 0)
    places_[at(value)] = column;
  else
    copies.push_back({kernel_of(copy), column, places_[at(value)], {}, {}, {}});
}

Place ProgramMaker::place(int value) {
  auto& place = places_[at(value)];
  if (place.base < 0) place = {results_base, rows * result_count_++};
  return place;
}

std::vector<Place> ProgramMaker::full_places(const std::vector<int>& values, ExpressionProgram& program) {
  std::vector<Place> full;
  for (const int value : values) {
    full.push_back(place(value));
    if (full.back().base <= constants_base) continue;
    const Place copied{results_base, rows * result_count_++};
    program.insert(program.end() - 1, {kernel_of(copy), copied, full.back(), {}, {}, {}});
    full.back() = copied;
  }
  return full;
}

TapeValue ProgramMaker::step(int value) const {
  TapeValue step = tape_[value];
  if (step.operation == power_slope && tape_.is_constant(step.b, 3.0)) step.c = -1;  // 3 a^2 needs no a^3
  if (step.operation != divide || tape_.is_constant(step.a, 1.0)) return step;
  const int one = tape_.find_constant(1.0), inverse = one < 0 ? -1 : tape_.find_step(divide, one, step.b);
  if (inverse < 0) return step;
  step.operation = multiply;
  step.b = inverse;
  return step;
}

ExpressionProgram ProgramMaker::make(const std::vector<int>& targets, std::vector<char>& known) {
  known_ = &known;
  known.resize(places_.size(), 0);
  uses_.assign(places_.size(), 0);
  program_.clear();
  for (const int target : targets) {
    count_uses(target);
    ++uses_[at(target)];  // a target is kept even if one step reads it
  }
  for (const int target : targets) emit(target);
  program_.push_back({kernel_of(finish), {}, {}, {}, {}, {}});
  return std::move(program_);
}

void ProgramMaker::count_uses(int value) {
  if (++uses_[at(value)] > 1 || !is_result(value) || (*known_)[at(value)] != 0) return;
  const TapeValue from = step(value);
  for (const int operand : {from.a, from.b, from.c})
    if (operand >= 0) count_uses(operand);
}

/// Whether the value is a result that only the step being made reads, and that nothing else has computed.
bool ProgramMaker::is_inner(int value) const {
  return value >= 0 && is_result(value) && (*known_)[at(value)] == 0 && uses_[at(value)] == 1;
}

bool ProgramMaker::is_inner(int value, TapeOperation operation) const {
  return is_inner(value) && step(value).operation == operation;
}

OperandForm ProgramMaker::form_of(int value) const {
  if (!is_inner(value)) return OperandForm::plain;
  const TapeValue from = step(value);
  switch (from.operation) {
    case absolute:
      return OperandForm::magnitude;
    case sign:
      return OperandForm::sign;
    case square:
      return OperandForm::square;
    case power:
      return tape_.is_constant(from.b, 3.0) ? OperandForm::cube : OperandForm::plain;
    case power_slope:
      return tape_.is_constant(from.b, 3.0) ? OperandForm::cube_slope : OperandForm::plain;
    default:
      return OperandForm::plain;
  }
}

/// Moves a factor that can be read in a form to the end.
void ProgramMaker::read_last_in_form(Factors& factors) const {
  for (auto& value : factors.values) {
    factors.form = form_of(value);
    if (factors.form == OperandForm::plain) continue;
    value = step(value).a;
    std::swap(value, factors.values.back());
    return;
  }
}

/// Two factors, or three where one of the two is itself a product.
ProgramMaker::Factors ProgramMaker::factors_of(const TapeValue& product) const {
  Factors factors{{product.a, product.b}};
  for (const std::size_t i : {0U, 1U}) {
    const int value = factors.values[i];
    if (!is_inner(value, multiply)) continue;
    const TapeValue inner = step(value);
    factors.values[i] = inner.a;
    factors.values.insert(factors.values.begin() + static_cast<std::ptrdiff_t>(i) + 1, inner.b);
    break;
  }
  read_last_in_form(factors);
  return factors;
}

Instruction ProgramMaker::instruction(TapeOperation operation, OperandForm form, const std::vector<int>& operands) {
  Instruction made;
  made.kernel = form == OperandForm::plain ? kernel_of(operation) : kernel_of(operation, form);
  Place* const places[] = {&made.a, &made.b, &made.c, &made.d};
  for (std::size_t i = 0; i < operands.size(); ++i) {
    if (operands[i] < 0) continue;
    emit(operands[i]);
    *places[i] = place(operands[i]);
  }
  return made;
}

Instruction ProgramMaker::product(const TapeValue& of) {
  const Factors factors = factors_of(of);
  return instruction(factors.values.size() == 3 ? multiply_three : multiply, factors.form, factors.values);
}

/// A sum or difference, with what it can take in of its operands.
Instruction ProgramMaker::sum(const TapeValue& of) {
  const bool plus = of.operation == add;
  int first = of.a, second = of.b;
  const auto with_first = [&](const std::vector<int>& factors) {
    std::vector<int> operands{first};
    operands.insert(operands.end(), factors.begin(), factors.end());
    return operands;
  };
  if (is_inner(first, multiply) && is_inner(second, multiply)) {
    Factors one = factors_of(first), other = factors_of(second);
    if (plus && one.form != OperandForm::plain) std::swap(one, other);
    const bool bare = one.form == OperandForm::plain && (plus || other.form == OperandForm::plain);
    if (bare && one.values.size() == 2 && other.values.size() == 2)
      return instruction(plus ? sum_of_products : difference_of_products, other.form,
                         {one.values[0], one.values[1], other.values[0], other.values[1]});
  }
  if (plus && !is_inner(second, multiply) && !is_inner(second, guarded_multiply)) std::swap(first, second);
  if (is_inner(second, multiply)) {
    const Factors factors = factors_of(second);
    if (factors.values.size() == 3)
      return instruction(plus ? multiply_three_add : subtract_three, factors.form, with_first(factors.values));
    return instruction(plus ? multiply_add : subtract_product, factors.form, with_first(factors.values));
  }
  if (is_inner(second, guarded_multiply)) {
    const TapeValue from = step(second);
    return instruction(plus ? guarded_multiply_add : guarded_subtract_product, OperandForm::plain,
                       with_first({from.a, from.b}));
  }
  if (is_inner(first, multiply)) {
    const TapeValue from = step(first);
    return instruction(multiply_subtract, OperandForm::plain, {from.a, from.b, second});
  }
  Factors terms{{first, second}};
  if (plus) read_last_in_form(terms);
  return instruction(of.operation, terms.form, terms.values);
}

void ProgramMaker::emit(int value) {
  if (!is_result(value) || (*known_)[at(value)] != 0) return;
  const TapeValue from = step(value);
  Instruction next;
  if (from.operation == add || from.operation == subtract) {
    next = sum(from);
  } else if (from.operation == multiply) {
    next = product(from);
  } else if (from.operation == divide && tape_.is_constant(from.a, 1.0) && is_inner(from.b, add)) {
    Factors terms{{step(from.b).a, step(from.b).b}};
    read_last_in_form(terms);
    next = instruction(inverse_of_sum, terms.form, terms.values);
  } else {
    TapeOperation operation = from.operation;
    if (operation == power && tape_.is_constant(from.b, 3.0)) operation = cube;
    if (operation == power_slope && tape_.is_constant(from.b, 3.0)) operation = cube_slope;
    next = instruction(operation, OperandForm::plain, {from.a, from.b, from.c});
  }
  next.out = place(value);
  program_.push_back(next);
  (*known_)[at(value)] = 1;
}

std::vector<int> ProgramMaker::needed_before(const std::vector<int>& targets, const std::vector<char>& later) const {
  const auto is_later = [&](int value) { return later[at(value)] != 0; };
  std::vector<char> seen(places_.size(), 0);
  std::vector<int> found, open = targets;
  while (!open.empty()) {
    const int value = open.back();
    open.pop_back();
    if (!is_result(value) || std::exchange(seen[at(value)], 1) != 0) continue;
    if (!is_later(value)) {
      found.push_back(value);
      continue;
    }
    const TapeValue from = step(value);
    for (const int operand : {from.a, from.b, from.c})
      if (operand >= 0) open.push_back(operand);
  }
  return found;
}

}  // namespace kalfem
