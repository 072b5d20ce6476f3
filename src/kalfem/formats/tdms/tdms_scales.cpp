// SPDX-License-Identifier: Apache-2.0
// Scales of a channel (NI_Scale properties): a chain of numbered steps, of which the last one gives the channel's
// values. Each takes its input from another step, from the raw numbers or from a DAQmx scaler.

#include <algorithm>
#include <cmath>
#include <optional>

#include "kalfem/formats/tdms/tdms_segments.hpp"

namespace kalfem::tdms {
namespace {

constexpr double raw_numbers = 4294967295.0;  ///< the input that stands for the channel's own numbers

/// Thrown with the reason why the scales cannot be applied.
struct NotSupported {
  std::string why;
};

class Scales {
public:
  Scales(const Object& object, const Properties& properties, std::size_t count)
      : object_(object), properties_(properties), count_(count) {}

  std::vector<double> result() const { return step(count_ - 1, 0); }

private:
  [[nodiscard]] const Property* property(std::size_t scale, const std::string& name) const {
    const auto found = properties_.find("NI_Scale[" + std::to_string(scale) + "]_" + name);
    return found == properties_.end() ? nullptr : &found->second;
  }

  [[nodiscard]] double number(std::size_t scale, const std::string& name, std::optional<double> otherwise = {}) const {
    const auto* found = property(scale, name);
    if (found != nullptr && std::holds_alternative<double>(*found)) return std::get<double>(*found);
    if (!otherwise) throw NotSupported{"its scale " + std::to_string(scale) + " has no " + name};
    return *otherwise;
  }

  [[nodiscard]] std::vector<double> list(std::size_t scale, const std::string& name, double size) const {
    if (!(size >= 0.0 && size <= static_cast<double>(properties_.size())))
      throw NotSupported{"its scale " + std::to_string(scale) + " does not list its " + name};
    std::vector<double> values;
    for (std::size_t i = 0; i < static_cast<std::size_t>(size); ++i)
      values.push_back(number(scale, name + "[" + std::to_string(i) + "]"));
    return values;
  }

  [[nodiscard]] std::vector<double> input(double source, std::size_t depth) const {
    if (source == raw_numbers) return object_.numbers.empty() ? std::vector<double>() : object_.numbers.front().values;
    if (!(source >= 0.0 && source < static_cast<double>(count_)))
      throw NotSupported{"a scale takes its input from one that is missing"};
    return step(static_cast<std::size_t>(source), depth + 1);
  }

  [[nodiscard]] std::vector<double> step(std::size_t scale, std::size_t depth) const {
    if (depth > count_) throw NotSupported{"its scales go round in a circle"};
    const auto* type = property(scale, "Scale_Type");
    if (type == nullptr || !std::holds_alternative<std::string>(*type)) return of_scaler(scale);
    const auto& name = std::get<std::string>(*type);
    if (name == "Linear") return linear(scale, depth);
    if (name == "Polynomial") return polynomial(scale, depth);
    if (name == "Table") return table(scale, depth);
    if (name == "Add" || name == "Subtract") return sum(scale, name, depth);
    throw NotSupported{"its scale '" + name + "' is not supported"};
  }

  [[nodiscard]] std::vector<double> of_scaler(std::size_t scale) const {
    for (const auto& numbers : object_.numbers)
      if (numbers.scaler == scale) return numbers.values;
    throw NotSupported{"its scale " + std::to_string(scale) + " has no type"};
  }

  [[nodiscard]] std::vector<double> linear(std::size_t scale, std::size_t depth) const {
    const double slope = number(scale, "Linear_Slope"), intercept = number(scale, "Linear_Y_Intercept");
    auto values = input(number(scale, "Linear_Input_Source", raw_numbers), depth);
    for (double& value : values) value = slope * value + intercept;
    return values;
  }

  [[nodiscard]] std::vector<double> polynomial(std::size_t scale, std::size_t depth) const {
    const auto coefficients =
        list(scale, "Polynomial_Coefficients", number(scale, "Polynomial_Coefficients_Size", 4.0));
    auto values = input(number(scale, "Polynomial_Input_Source", raw_numbers), depth);
    for (double& value : values) {
      double sum = 0.0;
      for (std::size_t i = coefficients.size(); i-- > 0;) sum = sum * value + coefficients[i];
      value = sum;
    }
    return values;
  }

  // The file calls the inputs of the table its scaled values and the outputs its pre-scaled ones.
  [[nodiscard]] std::vector<double> table(std::size_t scale, std::size_t depth) const {
    auto from = list(scale, "Table_Scaled_Values", number(scale, "Table_Scaled_Values_Size"));
    auto to = list(scale, "Table_Pre_Scaled_Values", number(scale, "Table_Pre_Scaled_Values_Size"));
    if (from.size() > 1 && from.front() > from.back()) {
      std::ranges::reverse(from);
      std::ranges::reverse(to);
    }
    if (from.empty() || from.size() != to.size() ||
        std::ranges::adjacent_find(from, std::greater_equal<>()) != from.end())
      throw NotSupported{"the table of its scale " + std::to_string(scale) + " does not increase"};
    auto values = input(number(scale, "Table_Input_Source", raw_numbers), depth);
    for (double& value : values) value = interpolated(from, to, value);
    return values;
  }

  /// Beyond the ends the end values hold.
  static double interpolated(const std::vector<double>& from, const std::vector<double>& to, double value) {
    const auto above = static_cast<std::size_t>(std::ranges::upper_bound(from, value) - from.begin());
    if (above == 0) return to.front();
    if (above == from.size()) return to.back();
    const double part = (value - from[above - 1]) / (from[above] - from[above - 1]);
    return to[above - 1] + part * (to[above] - to[above - 1]);
  }

  // A difference is right minus left: so do NI's own programs.
  [[nodiscard]] std::vector<double> sum(std::size_t scale, const std::string& name, std::size_t depth) const {
    auto left = input(number(scale, name + "_Left_Operand_Input_Source"), depth);
    const auto right = input(number(scale, name + "_Right_Operand_Input_Source"), depth);
    if (left.size() != right.size()) throw NotSupported{"its scales add series of different length"};
    const double sign = name == "Add" ? 1.0 : -1.0;
    for (std::size_t i = 0; i < left.size(); ++i) left[i] = right[i] + sign * left[i];
    return left;
  }

  const Object& object_;
  const Properties& properties_;
  std::size_t count_;
};

/// Number of scales that the properties state; 0: none.
std::size_t scale_count(const Properties& properties) {
  constexpr std::size_t most = 1000;
  if (const auto stated = properties.find("NI_Number_Of_Scales"); stated != properties.end())
    if (const auto* number = std::get_if<double>(&stated->second); number != nullptr && *number >= 0.0)
      return static_cast<std::size_t>(std::min(*number, static_cast<double>(most)));
  std::size_t count = 0;
  while (count < most && properties.contains("NI_Scale[" + std::to_string(count) + "]_Scale_Type")) ++count;
  return count;
}

bool is_scaled_already(const Properties& properties) {
  const auto status = properties.find("NI_Scaling_Status");
  return status != properties.end() && std::holds_alternative<std::string>(status->second) &&
         std::get<std::string>(status->second) == "scaled";
}

}  // namespace

std::vector<double> scaled(const Object& object, const std::vector<const Properties*>& levels, std::string& problem) {
  for (const Properties* properties : levels) {
    const auto count = scale_count(*properties);
    if (count == 0 || is_scaled_already(*properties)) continue;
    try {
      return Scales(object, *properties, count).result();
    } catch (const NotSupported& reason) {
      problem = reason.why;
      return {};
    }
  }
  return object.numbers.empty() ? std::vector<double>() : object.numbers.front().values;
}

}  // namespace kalfem::tdms
