#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kalfem/formats/nastran/card.hpp"

namespace kalfem::nastran {

/// What the case control section chooses: of the commands above all subcases and in the first one.
struct CaseControl {
  std::optional<Id> spc, mpc;
  std::optional<Id> material_temperature;  ///< TEMPERATURE, TEMPERATURE(MATERIAL) or (BOTH)
  /// Factor and name of each direct input matrix.
  std::vector<std::pair<double, std::string>> stiffness, mass, damping;
  /// What a SUBCASE chooses, with the commands above all of them; one without a number where there is no SUBCASE.
  struct Subcase {
    std::int64_t number = 1;
    std::optional<Id> load, spc;
    Place where;
  };
  std::vector<Subcase> subcases;
  bool is_present = false;     ///< the file has a case control section
  bool more_subcases = false;  ///< a second SUBCASE stands behind, which is not used
  Place second_subcase;
  std::vector<std::pair<std::string, Place>> unused;  ///< commands that would change the structure and are not used

  /// Reads one line of the executive or case control section. Commands that only ask for results are skipped.
  void read(std::string_view line, const Place& place);

private:
  void begin_subcase(const std::vector<std::string>& words, const Place& place);
  Subcase& present_subcase();

  Subcase above_;  ///< of the commands above all subcases
  int subcases_ = 0;
};

/// Whether a line begins the bulk data: BEGIN BULK, also with a comma or alone, but not of a superelement.
bool begins_bulk(std::string_view line);

}  // namespace kalfem::nastran
