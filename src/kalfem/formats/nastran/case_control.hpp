// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kalfem/formats/nastran/card.hpp"

namespace kalfem::nastran {

/// Factor and name of each direct input matrix.
using MatrixChoice = std::vector<std::pair<double, std::string>>;

/// What a SUBCASE chooses, with the commands above all of them.
struct Subcase {
  std::int64_t number = 1;
  Place where = {};
  std::optional<Id> load, spc, mpc, method, deform;
  std::optional<Id> material_temperature;  ///< TEMPERATURE(MATERIAL), (BOTH) or without brackets
  std::optional<Id> initial_temperature;   ///< TEMPERATURE(INITIAL)
  std::optional<Id> thermal_load;          ///< TEMPERATURE(LOAD), (BOTH) or without brackets
  std::optional<std::int64_t> preload;     ///< STATSUB, STATSUB(PRELOAD): the number of a static subcase
  Place preload_where = {};
  MatrixChoice stiffness, mass, damping;  ///< K2GG, M2GG, B2GG
  bool combines = false;                  ///< SUBCOM, SYMCOM: a sum of results of others
};

/// The executive and case control sections.
struct CaseControl {
  std::vector<Subcase> subcases;  ///< one without a number where there is no SUBCASE
  std::string solution;           ///< word of the SOL command, "103" or "SEMODES"; empty: none
  Place solution_where;
  bool is_present = false;                            ///< the file has a case control section
  std::vector<std::pair<std::string, Place>> unused;  ///< commands that would change the structure and are not used

  // Of the subcase whose structure the model is, see choose().
  Subcase chosen;
  std::optional<Id> spc, mpc, material_temperature;
  MatrixChoice stiffness, mass, damping;

  /// Reads one line of the executive or case control section. Commands that only ask for results are skipped.
  void read(std::string_view line, const Place& place);
  /// Takes the structure of a subcase: of this number, or else of the first with METHOD, or of the first. Returns
  /// whether there is one of this number.
  bool choose(std::optional<std::int64_t> number);
  /// Null where there is none.
  [[nodiscard]] const Subcase* find(std::int64_t number) const;
  /// The subcase whose stresses the chosen one carries; null where there is none, and in a buckling analysis, whose
  /// STATSUB names the load that buckles.
  [[nodiscard]] const Subcase* preload() const;
  /// Number of the solution sequence: 101 statics, 103 modes, 105 buckling, ...; 0 where it is unknown.
  [[nodiscard]] int solution_number() const;

private:
  void begin_subcase(const std::vector<std::string>& words, const Place& place);
  Subcase& present_subcase();

  Subcase above_;  ///< of the commands above all subcases
  int subcases_ = 0;
};

/// Whether a line begins the bulk data: BEGIN BULK, also with a comma or alone, but not of a superelement.
bool begins_bulk(std::string_view line);
/// Whether a deck begins with executive and case control; otherwise it is bulk data from its first line on.
bool has_case_control(std::string_view text);

}  // namespace kalfem::nastran
