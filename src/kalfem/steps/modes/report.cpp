// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/modes/report.hpp"

#include <fmt/ranges.h>

#include <algorithm>

#include "kalfem/page/words.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

const FiniteElementSubstructure* find_elements(const Study& study, const std::string& name) {
  const auto& all = study.structure->finite_elements;
  const auto found = std::ranges::find_if(all, [&](const auto& each) { return each.part->name == name; });
  return found == all.end() ? nullptr : &*found;
}

/// Two frequencies in four digits, in six where only these tell them apart.
std::pair<std::string, std::string> written_apart(double one, double other) {
  const auto six_digits = [](double value) { return fmt::format("{:.6g}", value); };
  const bool alike = four_digits(one) == four_digits(other) && six_digits(one) != six_digits(other);
  return alike ? std::pair(six_digits(one), six_digits(other)) : std::pair(four_digits(one), four_digits(other));
}

/// Below what it shows, the sign is that of rounding.
std::string difference_in_words(const ModeComparison& compared) {
  const std::string words = fmt::format("{:.4f} %", 100.0 * (compared.reduced / compared.full - 1.0));
  return words == "-0.0000 %" ? "0.0000 %" : words;
}

std::string updated_frequency(const SubstructureModes* updated, Index mode) {
  return updated && mode < updated->frequencies.size() ? four_digits(updated->frequencies[mode]) : "-";
}

std::vector<std::string> compared_row(const std::string& part, Index mode, const ModeComparison& compared,
                                      const SubstructureModes* updated) {
  const auto [full, reduced] = written_apart(compared.full, compared.reduced);
  return {part,
          std::to_string(mode + 1),
          updated_frequency(updated, mode),
          full,
          reduced,
          compared.full > 0.0 ? difference_in_words(compared) : "-",
          fmt::format("{:.6f}", compared.mac),
          fmt::format("{:.1e}", compared.residual)};
}

/// "'wheel' is lumped" or "'wheel' and 'body' are lumped"; empty without any.
std::string lumped_words(const Study& study, const StudyResults& results) {
  std::vector<std::string> names;
  for (const auto& part : modes_found(results).substructures)
    if (!find_elements(study, part.name)) names.push_back("'" + part.name + "'");
  if (names.empty()) return "";
  if (names.size() == 1) return names[0] + " is lumped: there is nothing to reduce.";
  const std::string last = names.back();
  names.pop_back();
  return fmt::format("{} and {} are lumped: there is nothing to reduce.", fmt::join(names, ", "), last);
}

/// Why modes of a finite-element substructure are not compared.
std::string reason_for_dashes(const FiniteElementSubstructure* elements, const SubstructureModes& part) {
  if (!elements) return "";
  if (!elements->reduced) return fmt::format("'{}' is not reduced: nothing is attached to its nodes.", part.name);
  const auto& indicators = elements->reduced->error_indicators;
  if (static_cast<Index>(indicators.modes.size()) >= part.frequencies.size()) return "";
  return indicators.highest_kept > 0.0
             ? fmt::format("The reduction of '{}' keeps modes up to {} Hz; those above are not compared.", part.name,
                           four_digits(indicators.highest_kept))
             : fmt::format(
                   "The reduction of '{}' keeps no modes: those above {} Hz, its first fixed-interface "
                   "frequency, are not compared.",
                   part.name, four_digits(indicators.next_left_out));
}

}  // namespace

Table modes_table(const Study& study, const StudyResults& results) {
  const bool updated = results.has<UpdatedModes>() && !results.get<UpdatedModes>().substructures.empty();
  const std::string label = updated ? "initial, " : "";
  Table table{"Modes",
              {"substructure", "mode", "updated, full [Hz]", label + "full [Hz]", label + "reduced [Hz]", "difference",
               "MAC", "residual"},
              {},
              {}};
  table.caption = lumped_words(study, results);
  if (updated)
    table.caption +=
        std::string(table.caption.empty() ? "" : " ") +
        "Updated: at the updated values. All other columns are at the initial values. Modes are counted by frequency "
        "in both.";
  for (const auto& part : modes_found(results).substructures) {
    const auto* elements = find_elements(study, part.name);
    const auto compared =
        elements && elements->reduced ? elements->reduced->error_indicators.modes : std::vector<ModeComparison>{};
    const auto count = static_cast<Index>(compared.size());
    const auto* changed = updated_modes_of(results, part.name);
    for (Index i = 0; i < count; ++i)
      table.rows.push_back(compared_row(part.name, i, compared[static_cast<std::size_t>(i)], changed));
    for (Index i = count; i < part.frequencies.size(); ++i)
      table.rows.push_back({part.name, std::to_string(i + 1), updated_frequency(changed, i),
                            four_digits(part.frequencies[i]), "-", "-", "-", "-"});
    if (const auto reason = reason_for_dashes(elements, part); !reason.empty())
      table.caption += (table.caption.empty() ? "" : " ") + reason;
  }
  return without_empty_columns(std::move(table));
}

Table joined_modes_table(const Study& study, const StudyResults& results) {
  Table table{"Modes of the joined structure", {"mode", "frequency [Hz]"}, {}, {}};
  for (Index i = 0; i < modes_found(results).joined_frequencies.size(); ++i)
    table.rows.push_back({std::to_string(i + 1), four_digits(modes_found(results).joined_frequencies[i])});
  const auto reduced = [](const FiniteElementSubstructure& each) { return each.reduced != nullptr; };
  table.caption = results.has<UpdatedModes>() ? "All parts together at the initial values, connectors linear about rest"
                                              : "All parts together, connectors linear about rest";
  table.caption += std::ranges::any_of(study.structure->finite_elements, reduced)
                       ? ", of the superelements: right up to about half of what these keep."
                       : ".";
  return table;
}

std::string mass_text(const FiniteElementPart& part) {
  const auto& moving = part.moving_mass;
  std::string text = four_digits(part.mass.mass) + " kg";
  if (moving.minCoeff() >= (1.0 - 1e-9) * part.mass.mass) return text;
  if (moving.maxCoeff() - moving.minCoeff() <= 1e-9 * part.mass.mass)
    return text + fmt::format(" (of which {} kg can move)", four_digits(moving[0]));
  return text + fmt::format(" (of which {}, {} and {} kg can move along x, y and z)", four_digits(moving[0]),
                            four_digits(moving[1]), four_digits(moving[2]));
}

std::string console_modes(const Study& study, const StudyResults& results) {
  std::string text;
  for (const Table& table : {modes_table(study, results), joined_modes_table(study, results)}) {
    if (table.rows.empty() && !text.empty()) continue;
    text += to_text(table) + (table.caption.empty() ? "" : "\n" + table.caption + "\n") + "\n";
  }
  return text;
}

}  // namespace kalfem
