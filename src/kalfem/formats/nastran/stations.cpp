// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran/stations.hpp"

#include <algorithm>

namespace kalfem::nastran {
namespace {

bool is_same(const SectionCard& a, const SectionCard& b) {
  const auto constants = [](const SectionCard& s) {
    return std::array{s.area, s.i1, s.i2, s.i12, s.torsion, s.nonstructural_mass, s.k1, s.k2, s.nonstructural_inertia};
  };
  return constants(a) == constants(b) && a.neutral_axis == b.neutral_axis &&
         a.nonstructural_centre == b.nonstructural_centre;
}

}  // namespace

std::vector<Station> filled_stations(const std::vector<double>& end_a, std::vector<StationFields> given,
                                     const std::string& title) {
  std::ranges::sort(given, {}, &StationFields::place);
  if (given.empty() || given.back().place < 1.0) given.push_back({1.0, {}});
  if (!(given.front().place > 0.0) || given.back().place > 1.0)
    throw CardError(title + ": X/XB of a station is not between 0 and 1", "it is a share of the length from end A",
                    "correct it; end A stands in the first line");
  if (std::ranges::adjacent_find(given, {}, &StationFields::place) != given.end())
    throw CardError(title + " has two stations at one X/XB", "it is not clear which one applies", "remove one of them");
  std::vector<double> end_b = end_a;
  for (const auto& [i, value] : given.back().values) end_b[i] = value;
  std::vector<Station> stations = {{0.0, end_a}};
  for (const auto& [place, values] : given) {
    stations.emplace_back(place, std::vector<double>(end_a.size()));
    for (std::size_t i = 0; i < end_a.size(); ++i) {
      const auto value = values.find(i);
      stations.back().second[i] = value != values.end() ? value->second : (1.0 - place) * end_a[i] + place * end_b[i];
    }
  }
  return stations;
}

SectionCard along(std::vector<std::pair<double, SectionCard>> stations) {
  const auto differs = [&](const auto& station) { return !is_same(station.second, stations.front().second); };
  SectionCard section = stations.front().second;
  if (std::ranges::none_of(stations, differs) && section.nonstructural_inertia == 0.0) return section;
  section.stations = std::move(stations);
  return section;
}

}  // namespace kalfem::nastran
