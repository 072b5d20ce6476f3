// SPDX-License-Identifier: Apache-2.0
// Inside of the reader of MATLAB files only.

#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/matlab/matlab_values.hpp"

namespace kalfem {

template <std::size_t count>
bool is_one_of(std::string_view name, const std::array<std::string_view, count>& names) {
  return std::ranges::find(names, lower_case(name)) != names.end();
}

inline constexpr std::array<std::string_view, 4> matlab_unit_names = {"unit", "units", "y_unit", "unit_string"};

bool is_vector(const MatlabValue& value);
Eigen::VectorXd as_vector(const Eigen::MatrixXd& values);

/// Whether a field holds times by its name; less certain names must hold increasing numbers.
bool is_time(const std::string& name, const MatlabValue& value);

/// A field that is not copied: it may be large.
struct NamedValue {
  std::string name;
  const MatlabValue* value = nullptr;
};

/// The fields with axes that stand in a structure of their own beside the values: x_values of Testlab, X of dSPACE.
/// Their numbers get the name "time".
std::vector<NamedValue> with_axis_fields(const MatlabFields& fields);

/// The fields around a series, innermost first: what states its times, frequencies and units.
class Scope {
public:
  explicit Scope(const std::vector<NamedValue>& fields, const Scope* around = nullptr)
      : fields_(fields), around_(around) {}

  /// Of the same structure only.
  [[nodiscard]] const std::vector<NamedValue>& fields() const { return fields_; }

  template <class Test>
  [[nodiscard]] const NamedValue* find(const Test& test) const {
    for (const auto& field : fields_)
      if (test(field.name, *field.value)) return &field;
    return around_ == nullptr ? nullptr : around_->find(test);
  }

  template <std::size_t count>
  [[nodiscard]] std::optional<double> number(const std::array<std::string_view, count>& names) const {
    const auto* found = find([&](const std::string& name, const MatlabValue& each) {
      return each.kind == MatlabValue::Kind::numbers && each.real.size() == 1 && is_one_of(name, names);
    });
    return found == nullptr || !std::isfinite(found->value->real(0)) ? std::nullopt
                                                                     : std::optional(found->value->real(0));
  }

  /// Of the same structure only.
  template <std::size_t count>
  [[nodiscard]] std::string text(const std::array<std::string_view, count>& names) const {
    for (const auto& [name, value] : fields_)
      if (value->kind == MatlabValue::Kind::text && is_one_of(name, names)) return value->text;
    return "";
  }

private:
  const std::vector<NamedValue>& fields_;
  const Scope* around_;
};

}  // namespace kalfem
