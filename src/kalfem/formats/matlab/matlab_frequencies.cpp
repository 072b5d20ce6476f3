// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/matlab/matlab_frequencies.hpp"

#include <numbers>

#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

constexpr std::array<std::string_view, 6> exact_names = {"f", "freq", "frequency", "frequencies", "freq_hz", "f_hz"};
constexpr std::array<std::string_view, 8> near_names = {"faxis", "f_axis", "fvec", "f_vec", "fv", "ff", "hz", "lines"};
constexpr std::array<std::string_view, 5> angular_names = {"w", "omega", "om", "wvec", "omegas"};
constexpr std::array<std::string_view, 8> axis_names = {"x",    "xdata",    "x_axis", "xaxis",
                                                        "axis", "abscissa", "xval",   "time"};
constexpr std::array<std::string_view, 9> step_names = {"df",   "delta_f",   "deltaf",  "freq_step", "f_step",
                                                        "fres", "increment", "delta_x", "resolution"};
constexpr std::array<std::string_view, 6> first_names = {"f0",          "fstart", "f_start", "start_frequency",
                                                         "start_value", "x0"};

bool is_angular(std::string_view name) {
  const std::string word = lower_case(name);
  return is_one_of(name, angular_names) || word.starts_with("omega") || word.ends_with("_rad") ||
         word.ends_with("rad_s") || word.ends_with("radps");
}

bool may_be_frequencies(const MatlabValue& value) {
  return is_vector(value) && value.imaginary.size() == 0 && value.real(0) >= 0.0 && increases(as_vector(value.real));
}

FrequencyAxis axis_of(const NamedValue& found) {
  FrequencyAxis axis{as_vector(found.value->real), found.value, ""};
  if (is_angular(found.name)) {
    axis.lines /= 2.0 * std::numbers::pi;
    axis.note = "'" + found.name + "' is taken as angular frequencies [rad/s]";
  }
  return axis;
}

/// The only vector beside the array that may hold them.
const NamedValue* only_candidate(const Scope& scope, const auto& fits) {
  const NamedValue* found = nullptr;
  for (const auto& field : scope.fields()) {
    if (!fits(*field.value) || !may_be_frequencies(*field.value)) continue;
    if (found != nullptr) return nullptr;
    found = &field;
  }
  return found;
}

}  // namespace

bool is_exact_frequency_name(std::string_view name) { return is_one_of(name, exact_names); }

bool is_frequency_name(std::string_view name) {
  const std::string word = lower_case(name);
  return is_one_of(name, exact_names) || is_one_of(name, near_names) || is_angular(name) || word.starts_with("freq") ||
         word.ends_with("freq") || word.ends_with("frequency") || word.ends_with("_hz");
}

std::optional<FrequencyAxis> frequencies_for(const std::vector<Index>& lengths, const Scope& scope) {
  const auto fits = [&](const MatlabValue& value) {
    return is_vector(value) && value.imaginary.size() == 0 &&
           (value.real.size() == lengths.front() || value.real.size() == lengths.back());
  };
  const auto named = [&](const auto& is_name) {
    return scope.find([&](const std::string& name, const MatlabValue& value) { return is_name(name) && fits(value); });
  };
  if (const auto* found = named(is_exact_frequency_name)) return axis_of(*found);
  for (const auto* found :
       {named(is_frequency_name), named([](const std::string& name) { return is_one_of(name, axis_names); })})
    if (found != nullptr && may_be_frequencies(*found->value)) return axis_of(*found);
  if (const auto step = scope.number(step_names); step && *step > 0.0) {
    const double first = scope.number(first_names).value_or(0.0);
    const auto count = static_cast<double>(std::max(lengths.front(), lengths.back()));
    return FrequencyAxis{Eigen::VectorXd::LinSpaced(static_cast<Index>(count), first, first + (count - 1.0) * *step),
                         nullptr, ""};
  }
  const auto as_long = [&](const MatlabValue& value) {
    return fits(value) && value.real.size() == std::max(lengths.front(), lengths.back());
  };
  if (const auto* found = only_candidate(scope, as_long)) {
    auto axis = axis_of(*found);
    axis.note =
        "'" + found->name + "' is taken as frequencies [Hz]: it is the only vector of that length that increases";
    return axis;
  }
  return std::nullopt;
}

}  // namespace kalfem
