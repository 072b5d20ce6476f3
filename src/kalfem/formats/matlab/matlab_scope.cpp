// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/matlab/matlab_scope.hpp"

#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {

using Kind = MatlabValue::Kind;

bool is_vector(const MatlabValue& value) {
  return value.kind == Kind::numbers && (value.real.rows() == 1 || value.real.cols() == 1) && value.real.size() > 1;
}

Eigen::VectorXd as_vector(const Eigen::MatrixXd& values) { return Eigen::VectorXd::Map(values.data(), values.size()); }

bool is_time(const std::string& name, const MatlabValue& value) {
  if (!is_vector(value) || value.imaginary.size() > 0) return false;
  return is_time_name(name) || is_one_of(name, std::array<std::string_view, 3>{"times", "timestamps", "tvec"}) ||
         (may_be_time_name(name) && increases(as_vector(value.real)));
}

std::vector<NamedValue> with_axis_fields(const MatlabFields& fields) {
  std::vector<NamedValue> all;
  for (const auto& [name, value] : fields) all.push_back({name, &value});
  for (const auto& [name, value] : fields) {
    if (value.kind != Kind::structure || value.elements.size() != 1) continue;
    const bool axis = is_one_of(name, std::array<std::string_view, 3>{"x_values", "x", "xdata"});
    for (const auto& [inner, part] : value.elements.front()) {
      const bool values = is_vector(part) && is_one_of(inner, std::array<std::string_view, 2>{"data", "values"});
      if (axis) all.push_back({values ? "time" : inner, &part});
    }
  }
  return all;
}

}  // namespace kalfem
