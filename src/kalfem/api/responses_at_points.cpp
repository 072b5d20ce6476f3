// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/responses_at_points.hpp"

#include "kalfem/api/modes_at_points.hpp"

namespace kalfem {
namespace {

ResponseQuantity quantity_of(const OutputDescription& output) {
  switch (output.quantity) {
    case ObservedQuantity::displacement:
      return ResponseQuantity::displacement;
    case ObservedQuantity::velocity:
      return ResponseQuantity::velocity;
    case ObservedQuantity::acceleration:
      return ResponseQuantity::acceleration;
    default:
      throw InvalidInput("outputs: one is no motion of a point", "frequency responses are of motions", "");
  }
}

}  // namespace

MeasuredFrf responses_at_points(const MeasuredResponses& given) {
  const auto [substructure, input] = split_point(given.input);
  MeasuredFrf measured{.name = "values",
                       .response = {.lines = given.frequencies, .values = given.values, .deviations = given.std},
                       .set = {.input = FrfInput::force, .place = input}};
  for (const auto& output : given.outputs) {
    if (output.points.size() != 1 || output.points.begin()->second != 1.0 || output.relative_to_base)
      throw InvalidInput("outputs: one is not the absolute motion of a single point", "each column is one response",
                         "compare each by itself");
    measured.set.quantity = quantity_of(output);
    if (output.quantity != given.outputs.front().quantity)
      throw InvalidInput("outputs: they are of different quantities", "one comparison is of one quantity",
                         "make a comparison of each");
    measured.set.outputs.push_back(point_in(substructure, output.points.begin()->first));
    measured.response.outputs.push_back({measured.set.outputs.back(), unit_of(measured.set)});
  }
  return measured;
}

FrfResidualOptions response_options(const MeasuredResponses& given) {
  FrfResidualOptions options{.relative_deviation = given.relative_std};
  if (given.std.size() > 0) options.floor = 0.0;
  return options;
}

}  // namespace kalfem
