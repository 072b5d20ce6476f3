#include "kalfem/study/channel_unit.hpp"

#include <cmath>
#include <optional>

#include "kalfem/base/units.hpp"

namespace kalfem {

namespace {

constexpr double same_factor = 1e-9;  ///< relative

/// The unit as one of the channel's quantity. Throws InvalidInput.
Unit unit_for(const WantedChannel& wanted, const std::string& text) {
  try {
    return parse_unit_as(text, wanted.unit);
  } catch (const InvalidInput&) {
    if (wanted.rotational_unit.empty()) throw;
    const Unit unit = parse_unit(text);
    if (unit.dimension != parse_unit(wanted.rotational_unit).dimension) throw;
    return unit;
  }
}

/// The same, or as it is where it belongs to another quantity; nothing where it is not understood.
std::optional<Unit> understood(const WantedChannel& wanted, const std::string& text) {
  try {
    return unit_for(wanted, text);
  } catch (const InvalidInput&) {
  }
  try {
    return parse_unit(text);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

bool same_unit(const Unit& a, const Unit& b) {
  return a.dimension == b.dimension && std::abs(a.factor / b.factor - 1.0) < same_factor;
}

std::string place_in_words(const SourceLocation& place) {
  return place.file + (place.line > 0 ? ":" + std::to_string(place.line) : "");
}

double factor_of_case(const WantedChannel& wanted, const Channel& in_file, const SourceLocation& title,
                      IssueList& issues) {
  const auto& given = wanted.unit_given;
  const Unit unit = unit_for(wanted, given.value);
  const auto of_file = in_file.unit.empty() ? std::nullopt : understood(wanted, in_file.unit);
  if (of_file && !same_unit(*of_file, unit))
    issues.add(given.location,
               given.path + " is '" + given.value + "', but the column '" + in_file.name + "' (" + wanted.owner +
                   ") is in '" + in_file.unit + "'",
               place_in_words(title) + " says so",
               given.path == wanted.unit_key ? "take the wrong one out" : "take it out, or set " + wanted.unit_key);
  return unit.factor;
}

}  // namespace

std::string rotational_unit_of(ObservedQuantity quantity) {
  switch (quantity) {
    case ObservedQuantity::displacement:
      return "rad";
    case ObservedQuantity::velocity:
      return "rad/s";
    case ObservedQuantity::acceleration:
      return "rad/s^2";
    default:
      return "";
  }
}

double factor_to_si(const WantedChannel& wanted, const Channel& in_file, const SourceLocation& title,
                    IssueList& issues) {
  const auto& given = wanted.unit_given;
  try {
    if (!given.value.empty()) return factor_of_case(wanted, in_file, title, issues);
    return in_file.unit.empty() ? 1.0 : unit_for(wanted, in_file.unit).factor;
  } catch (const InvalidInput& error) {
    for (const Issue& issue : error.issues()) {
      if (!given.value.empty())
        issues.add(given.location, given.path + ": " + issue.what + " (" + wanted.owner + ")", issue.why,
                   "write a unit like " + wanted.unit);
      else
        issues.add(title, "column '" + in_file.name + "' (" + wanted.owner + "): " + issue.what, issue.why,
                   understood(wanted, in_file.unit) || wanted.unit_key.empty()
                       ? "name another column, or mend its title"
                       : "state it in " + wanted.unit_key);
    }
    return 1.0;
  }
}

}  // namespace kalfem
