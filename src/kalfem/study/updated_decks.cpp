// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/updated_decks.hpp"

#include "kalfem/casefile/description.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// What the case states in the place of the deck's materials and regions.
std::vector<DeckValue> values_of_case(const std::string& substructure, const d::FiniteElements& given) {
  std::vector<DeckValue> values;
  for (const auto& [name, material] : given.materials) {
    const std::string cause = substructure + ".finite_elements.materials." + name;
    values.push_back({name + ".youngs_modulus", material.youngs_modulus, cause});
    values.push_back({name + ".density", material.density, cause});
    values.push_back({name + ".poissons_ratio", material.poissons_ratio, cause});
  }
  for (const auto& [name, region] : given.regions)
    if (const auto* shell = std::get_if<d::ShellRegion>(&region.property))
      values.push_back({name + ".thickness", shell->thickness, substructure + ".finite_elements.regions." + name});
  return values;
}

std::vector<DeckValue> updated_values(const Study& study, const std::string& substructure,
                                      const Eigen::VectorXd& values) {
  std::vector<DeckValue> updated;
  for (const auto& [index, target] : study.updating->bindings)
    if (target.owner == substructure)
      updated.push_back({target.name.substr(substructure.size() + 1), values[index],
                         study.updating->parameters[static_cast<std::size_t>(index)].name});
  return updated;
}

}  // namespace

UpdatedDecks updated_decks(const Study& study, const Eigen::VectorXd& values) {
  UpdatedDecks result;
  if (study.description->update && study.description->update->write_deck)
    result.folder = *study.description->update->write_deck;
  for (const auto& [name, substructure] : study.description->substructures) {
    const auto* file =
        substructure.finite_elements ? std::get_if<d::DeckFile>(&substructure.finite_elements->source) : nullptr;
    auto updated = updated_values(study, name, values);
    if (!file || updated.empty()) continue;
    auto all = values_of_case(name, *substructure.finite_elements);
    all.insert(all.end(), updated.begin(), updated.end());
    auto& deck = result.decks.emplace_back(SubstructureDeck{name, {}});
    try {
      deck.deck = updated_deck(file->file.value, all,
                               {.format = file->format, .temperature = file->temperature, .subcase = file->subcase},
                               file->units);
    } catch (const InvalidInput& error) {
      deck.failure = error.issues().front().what;
    }
  }
  return result;
}

}  // namespace kalfem
