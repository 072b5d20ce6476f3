// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/matlab/matlab_units.hpp"

#include "kalfem/formats/matlab/matlab_frequencies.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

using Kind = MatlabValue::Kind;

/// "g, N" as two texts; a single one where there is no comma or semicolon.
std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts;
  const char separator = text.find(';') != std::string::npos ? ';' : ',';
  for (const auto part : split_cells(text, separator)) parts.emplace_back(part);
  return parts;
}

/// The texts of cells; nothing where one holds something else.
std::vector<std::string> texts_in(const MatlabValue& cells) {
  std::vector<std::string> texts;
  for (const auto& element : cells.elements) {
    if (element.size() != 1 || element.front().value.kind != Kind::text) return {};
    texts.push_back(element.front().value.text);
  }
  return texts;
}

/// Names of the numeric fields that are as long as the longest one, without times and frequencies.
std::vector<std::string> series_in(const std::vector<NamedValue>& fields) {
  const auto length = [](const MatlabValue& value) { return std::max(value.real.rows(), value.real.cols()); };
  const bool has_functions =
      std::ranges::any_of(fields, [](const NamedValue& field) { return field.value->imaginary.size() > 0; });
  const auto counts = [&](const NamedValue& field) {
    return field.value->kind == Kind::numbers && field.value->real.size() > 1 && !is_time(field.name, *field.value) &&
           !(has_functions && is_vector(*field.value) && is_frequency_name(field.name));
  };
  Eigen::Index longest = 0;
  for (const auto& field : fields)
    if (counts(field)) longest = std::max(longest, length(*field.value));
  std::vector<std::string> names;
  for (const auto& field : fields)
    if (counts(field) && length(*field.value) == longest) names.push_back(field.name);
  return names;
}

}  // namespace

SeriesUnits::SeriesUnits(const Scope& scope, const std::string& path)
    : path_(path), series_(series_in(scope.fields())) {
  for (const auto& [name, value] : scope.fields()) {
    const std::string lower = lower_case(name);
    for (const auto& each : series_)  // acc_unit, unit_acc
      if (value->kind == Kind::text && (lower == lower_case(each) + "_unit" || lower == lower_case(each) + "_units" ||
                                        lower == "unit_" + lower_case(each)))
        by_name_.push_back({each, value});
    if (!is_one_of(name, matlab_unit_names) || !key_.empty()) continue;
    key_ = name;
    if (value->kind == Kind::cells) list_ = texts_in(*value);
    if (value->kind == Kind::structure && value->elements.size() == 1)
      for (const auto& [inner, part] : value->elements.front())
        if (part.kind == Kind::text) by_name_.push_back({inner, &part});
    if (value->kind != Kind::text) continue;
    list_ = parts_of(value->text);
    if (list_.size() > 1) continue;
    list_.clear();
    single_ = value->text;
  }
}

std::string SeriesUnits::unit_of(const std::string& series, Eigen::Index column, Eigen::Index columns) const {
  const auto own = std::ranges::find(by_name_, series, &NamedValue::name);
  if (own != by_name_.end()) return own->value->text;
  const auto place = std::ranges::find(series_, series);
  if (place == series_.end()) return "";
  if (series_.size() == 1 && single_) return *single_;
  if (series_.size() == 1 && std::ssize(list_) == columns) return list_[static_cast<std::size_t>(column)];
  if (list_.size() == series_.size()) return list_[static_cast<std::size_t>(place - series_.begin())];
  return "";
}

std::string SeriesUnits::note(const std::string& series, Eigen::Index columns) const {
  const auto place = std::ranges::find(series_, series);
  if (key_.empty() || place == series_.end() ||
      std::ranges::find(by_name_, series, &NamedValue::name) != by_name_.end())
    return "";
  const std::string key = "'" + (path_.empty() ? key_ : path_ + "." + key_) + "'";
  if (single_ && series_.size() > 1 && place == series_.begin())
    return key + " states one unit, '" + *single_ + "', beside " + std::to_string(series_.size()) + " series (" +
           series_[0] + ", " + series_[1] + (series_.size() > 2 ? ", ..." : "") +
           "): it is not used, as it cannot be that of all; state the unit of each channel";
  if (single_ && series_.size() == 1 && columns > 1)
    return key + " states one unit, '" + *single_ + "': it is taken for all " + std::to_string(columns) +
           " channels of '" + series + "'";
  const bool fits = list_.size() == series_.size() || (series_.size() == 1 && std::ssize(list_) == columns);
  if (!list_.empty() && !fits && place == series_.begin())
    return key + " lists " + std::to_string(list_.size()) + " units, which are neither one a series (" +
           std::to_string(series_.size()) + ") nor one a channel: they are not used";
  return "";
}

}  // namespace kalfem
