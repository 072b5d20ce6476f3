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

TapeValue ProgramMaker::step(int value) const {
  TapeValue step = tape_[value];
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

/// Whether the value is a product that can be computed with the sum that reads it.
bool ProgramMaker::joins(int value) const {
  if (!is_result(value) || (*known_)[at(value)] != 0 || uses_[at(value)] != 1) return false;
  const auto operation = step(value).operation;
  return operation == multiply || operation == guarded_multiply;
}

Place ProgramMaker::place_of_operand(int value) {
  if (value < 0) return {};
  emit(value);
  return place(value);
}

void ProgramMaker::emit(int value) {
  if (!is_result(value) || (*known_)[at(value)] != 0) return;
  const TapeValue from = step(value);
  Instruction next;
  TapeOperation operation = from.operation;
  if (tape_.is_constant(from.b, 3.0))
    operation = operation == power ? cube : operation == power_slope ? cube_slope : operation;
  if ((operation == add || operation == subtract) && (joins(from.a) || joins(from.b))) {
    emit_sum(from, next, operation);
  } else {
    next.a = place_of_operand(from.a);
    next.b = place_of_operand(from.b);
    next.c = place_of_operand(from.c);
  }
  next.kernel = kernel_of(operation);
  next.out = place(value);
  program_.push_back(next);
  (*known_)[at(value)] = 1;
}

/// a b + c, a b - c, c - a b, a b + c d or a b - c d.
void ProgramMaker::emit_sum(const TapeValue& sum, Instruction& out, TapeOperation& operation) {
  const bool plus = operation == add;
  int first = sum.a, second = sum.b;
  const auto is_plain = [&](int value) { return joins(value) && step(value).operation == multiply; };
  if (is_plain(first) && is_plain(second)) {
    operation = plus ? sum_of_products : difference_of_products;
    out.c = place_of_operand(step(second).a);
    out.d = place_of_operand(step(second).b);
  } else if (joins(second) || (plus && joins(first))) {
    if (!joins(second)) std::swap(first, second);
    const bool guarded = !is_plain(second);
    operation = plus ? (guarded ? guarded_multiply_add : multiply_add)
                     : (guarded ? guarded_subtract_product : subtract_product);
    out.c = place_of_operand(first);
    first = second;
  } else if (is_plain(first)) {
    operation = multiply_subtract;
    out.c = place_of_operand(second);
  } else {
    out.a = place_of_operand(first);
    out.b = place_of_operand(second);
    return;
  }
  out.a = place_of_operand(step(first).a);
  out.b = place_of_operand(step(first).b);
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
