// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/updated_deck.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <system_error>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/abaqus.hpp"
#include "kalfem/formats/nastran.hpp"
#include "kalfem/formats/rewriting/deck_text.hpp"
#include "kalfem/formats/rewriting/region_numbers.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;
using rewriting::DeckText;
using rewriting::FieldPlace;
using rewriting::MaterialUse;
using rewriting::Texts;
using rewriting::Unwritable;

/// A deck with the texts of all its files.
struct ReadDeck {
  Deck deck;
  Texts texts;
  DeckOrigins origins = {};  ///< of Abaqus and CalculiX
};

bool is_of_abaqus(const fs::path& file, DeckFormat format) {
  return format == DeckFormat::abaqus ||
         (format == DeckFormat::automatic && lower_case(file.extension().string()) == ".inp");
}

/// Reads the deck; files that stand in `instead` are those.
ReadDeck read(const fs::path& file, const DeckOptions& options, const Texts& instead = {}) {
  ReadDeck result;
  const auto load = [&](const fs::path& path) {
    const auto replaced = instead.find(path.string());
    return result.texts[path.string()] = replaced == instead.end() ? read_text(path) : replaced->second;
  };
  const std::string content = load(file);
  result.deck = is_of_abaqus(file, options.format)
                    ? parse_abaqus(content, file.string(), load, options, &result.origins)
                    : parse_nastran(content, file.string(), load, options);
  return result;
}

/// The number of a model that a parameter is; nothing where it has none of that name.
std::optional<double> value_of(const FiniteElementModel& model, const std::string& parameter) {
  const auto [name, quantity] = rewriting::split_name(parameter);
  const auto of_name = [&](const auto& items, auto member) -> std::optional<double> {
    for (const auto& item : items)
      if (item.name == name) return item.*member;
    return std::nullopt;
  };
  if (quantity == "youngs_modulus" || quantity == "density" || quantity == "poissons_ratio") {
    const auto found = model.materials.find(name);
    if (found == model.materials.end()) return std::nullopt;
    if (quantity == "poissons_ratio") return found->second.poissons_ratio;
    return quantity == "density" ? found->second.density : found->second.youngs_modulus;
  }
  const auto region = model.properties.find(name);
  const bool is_region = region != model.properties.end();
  if (quantity == "thickness") {
    const auto* shell = is_region ? std::get_if<ShellProperty>(&region->second) : nullptr;
    return shell ? std::optional(shell->thickness) : std::nullopt;
  }
  if (quantity == "mass") return of_name(model.masses, &PointMass::mass);
  if (quantity != "stiffness") return std::nullopt;
  if (is_region && std::holds_alternative<BeamProperty>(region->second)) return 1.0;
  if (const auto spring = of_name(model.springs, &NodalSpring::stiffness)) return spring;
  return of_name(model.joints, &JointSpring::stiffness);
}

/// What one parameter is multiplied by.
struct Change {
  double ratio = 1.0;
  std::string cause;
};

/// What a card that is made of a material needs of it.
struct Needed {
  double stiffness = 1.0, density = 1.0;
  friend auto operator<=>(const Needed&, const Needed&) = default;
};

/// Asks the text of a deck for changes, in the terms of the model.
class Rewriting {
public:
  Rewriting(const FiniteElementModel& model, double length_unit, DeckText& text, UpdatedDeck& result)
      : model_(model), length_unit_(length_unit), text_(text), result_(result) {}

  void ask_for(const std::vector<DeckValue>& values) {
    for (const auto& value : values) take(value);
    scale_fields();
    for (const auto& material : materials_) scale_material(material);
  }

  [[nodiscard]] const std::map<std::string, Change>& changes() const { return changes_; }

private:
  void take(const DeckValue& value);
  void scale_fields();
  /// Whether the field is what the region has.
  [[nodiscard]] bool is_thickness(double thickness, const std::vector<FieldPlace>& places) const {
    return std::ranges::all_of(places, [&](const auto& place) {
      return std::abs(text_.number(place) * length_unit_ - thickness) <= 1e-9 * thickness;
    });
  }
  void scale_material(const std::string& material);
  void scale_uses(const std::string& material, const std::vector<MaterialUse>& uses);
  [[nodiscard]] Needed needed_by(const MaterialUse& use, const std::string& material) const;
  [[nodiscard]] rewriting::Numbers numbers_of(const std::string& material, const Needed& needed) const;
  [[nodiscard]] double ratio_of(const std::string& parameter) const {
    const auto found = changes_.find(parameter);
    return found == changes_.end() ? 1.0 : found->second.ratio;
  }
  void leave(const std::string& parameter, const Unwritable& reason) {
    result_.unwritten.push_back({changes_.at(parameter).cause, reason.what(), reason.fix()});
    changes_.erase(parameter);
  }
  [[nodiscard]] std::vector<std::string> parameters_of(const std::string& material) const;
  [[nodiscard]] std::string cause_of(const std::string& material, const std::string& without) const;

  const FiniteElementModel& model_;
  double length_unit_;  ///< of the deck [m]
  DeckText& text_;
  UpdatedDeck& result_;
  std::map<std::string, Change> changes_;  ///< by parameter
  std::set<std::string> materials_;        ///< whose numbers, or those of a region made of them, change
};

void Rewriting::take(const DeckValue& value) {
  const std::string cause = value.cause.empty() ? value.parameter : value.cause;
  const auto [name, quantity] = rewriting::split_name(value.parameter);
  const auto present = value_of(model_, value.parameter);
  const auto leave_at_once = [&](const char* why, const char* fix) { result_.unwritten.push_back({cause, why, fix}); };
  if (!present && quantity.starts_with("offset_"))
    return leave_at_once("offsets of a mass are along global axes, its card may have others", "write them by hand");
  if (!present && (quantity == "axial" || quantity == "torsion" || quantity.starts_with("bending")))
    return leave_at_once("a factor of one motion of beams is no number of their card",
                         "multiply A, I1, I2 or J by hand where mass does not depend on them");
  if (!present && quantity == "factor")
    return leave_at_once("a factor multiplies elements or matrices, not a field of a card",
                         "give these elements a material of their own and multiply its modulus by hand");
  if (!present) return leave_at_once("no card of the deck holds it: it is of the case", "add it to the deck by hand");
  changes_.erase(value.parameter);  // the last one counts
  if (quantity == "poissons_ratio" && value.value != *present)
    return leave_at_once("Poisson's ratio is another one than in the deck",
                         "write it, with G where it is given, by hand");
  if (quantity == "poissons_ratio" || value.value == *present) return;
  if (*present == 0.0) return leave_at_once("it is 0 or blank in the deck", "give it a value there, and update again");
  const double ratio = value.value / *present;
  changes_[value.parameter] = {ratio, cause};
  const bool of_material = quantity == "youngs_modulus" || quantity == "density";
  const auto region = model_.properties.find(name);
  if (of_material) materials_.insert(name);
  if (quantity == "stiffness" && region != model_.properties.end()) materials_.insert(material_of(region->second));
}

// Several springs may have one property, and several regions one section: all that a field states must change alike.
void Rewriting::scale_fields() {
  std::map<FieldPlace, std::set<double>> ratios;
  const auto enter = [&](const std::string& parameter) {
    try {
      for (const auto& place : text_.fields_of(parameter)) ratios[place].insert(ratio_of(parameter));
    } catch (const Unwritable&) {
      // Only those that change are told.
    }
  };
  for (const auto& spring : model_.springs) enter(spring.name + ".stiffness");
  for (const auto& joint : model_.joints) enter(joint.name + ".stiffness");
  for (const auto& [region, property] : model_.properties)
    if (std::holds_alternative<ShellProperty>(property)) enter(region + ".thickness");
  for (const auto& mass : model_.masses) enter(mass.name + ".mass");
  std::set<FieldPlace> done;
  for (const auto& [parameter, change] : std::map(changes_)) {
    const auto [name, quantity] = rewriting::split_name(parameter);
    const bool of_region = quantity == "stiffness" && model_.properties.contains(name);
    if (of_region || quantity == "youngs_modulus" || quantity == "density") continue;
    try {
      const auto places = text_.fields_of(parameter);
      for (const auto& place : places)
        if (ratios[place].size() > 1)
          throw Unwritable("its field also states what does not change alike",
                           "update what shares it by one parameter, or give it a card of its own");
      if (quantity == "thickness" && !is_thickness(*value_of(model_, parameter), places))
        throw Unwritable("the thickness is given at the elements (T1 to T4)", "change it there by hand");
      std::vector<double> values;
      for (const auto& place : places) values.push_back(text_.number(place) * change.ratio);
      for (std::size_t i = 0; i < places.size(); ++i)
        if (done.insert(places[i]).second) text_.set(places[i], values[i], change.cause);
    } catch (const Unwritable& reason) {
      leave(parameter, reason);
    }
  }
}

/// Parameters that change and that a material's cards depend on: its own, and factors of regions made of it.
std::vector<std::string> Rewriting::parameters_of(const std::string& material) const {
  std::vector<std::string> names;
  for (const auto& [parameter, change] : changes_) {
    const auto [name, quantity] = rewriting::split_name(parameter);
    const auto region = model_.properties.find(name);
    const bool is_factor = quantity == "stiffness" && region != model_.properties.end();
    if ((is_factor && material_of(region->second) == material) ||
        (name == material && (quantity == "youngs_modulus" || quantity == "density")))
      names.push_back(parameter);
  }
  return names;
}

/// What asks for changes of a material, but for those of one quantity.
std::string Rewriting::cause_of(const std::string& material, const std::string& without) const {
  std::string cause;
  for (const auto& parameter : parameters_of(material))
    if (rewriting::split_name(parameter).second != without)
      cause += (cause.empty() ? "" : ", ") + changes_.at(parameter).cause;
  return cause;
}

void Rewriting::scale_material(const std::string& material) {
  try {
    scale_uses(material, text_.uses_of(material, model_));
  } catch (const Unwritable& reason) {
    for (const auto& parameter : parameters_of(material)) leave(parameter, reason);
  }
}

// Where all cards need the material alike, its own numbers change. Otherwise it stays for those that need it as it is,
// and each group of the others gets a copy.
void Rewriting::scale_uses(const std::string& material, const std::vector<MaterialUse>& uses) {
  std::map<Needed, std::vector<MaterialUse>> groups;
  for (const auto& use : uses)
    if (use.is_fixed || !use.regions.empty()) groups[needed_by(use, material)].push_back(use);
  if (groups.size() == 1) {
    for (const auto& [place, value, cause] : numbers_of(material, groups.begin()->first))
      text_.set(place, value, cause);
    return;
  }
  for (const auto& [needed, users] : groups)
    if (needed != Needed{}) text_.split(material, numbers_of(material, needed), users, cause_of(material, ""));
}

/// The ratios that the regions of a card need, which must be the same for all of them.
Needed Rewriting::needed_by(const MaterialUse& use, const std::string& material) const {
  if (use.is_fixed) return {};
  std::set<Needed> all;
  for (const auto& region : use.regions) {
    const auto& property = model_.properties.at(region);
    Needed needed;
    const auto* solid = std::get_if<SolidProperty>(&property);
    const bool has_own_stiffness = solid && solid->elasticity;
    if (material_of(property) == material) {
      if (!has_own_stiffness) needed.stiffness = ratio_of(material + ".youngs_modulus");
      if (std::holds_alternative<BeamProperty>(property)) needed.stiffness *= ratio_of(region + ".stiffness");
      needed.density = ratio_of(material + ".density");
    }
    all.insert(needed);
  }
  if (all.size() > 1)
    throw Unwritable("one card states the material of regions that do not change alike",
                     "update them by one parameter, or give them cards of their own");
  return *all.begin();
}

rewriting::Numbers Rewriting::numbers_of(const std::string& material, const Needed& needed) const {
  rewriting::Numbers numbers;
  const auto add = [&](const char* quantity, double ratio, const std::string& cause) {
    if (ratio == 1.0) return;
    for (const auto& place : text_.material_fields(material, quantity))
      numbers.push_back({place, text_.number(place) * ratio, cause});
  };
  const auto of_density = changes_.find(material + ".density");
  add("youngs_modulus", needed.stiffness, cause_of(material, "density"));
  add("density", needed.density, of_density == changes_.end() ? "" : of_density->second.cause);
  return numbers;
}

/// What the model shall be: the one of the deck with the changes.
rewriting::ModelNumbers expected_numbers(const FiniteElementModel& model,
                                         const std::map<std::string, Change>& changes) {
  auto numbers = rewriting::numbers_of(model);
  const auto ratio_of = [&](const std::string& parameter) {
    const auto found = changes.find(parameter);
    return found == changes.end() ? 1.0 : found->second.ratio;
  };
  for (auto& [name, values] : numbers.regions) {
    const auto& property = model.properties.at(name);
    const auto material = material_of(property);
    if (material.empty()) continue;
    const auto* solid = std::get_if<SolidProperty>(&property);
    if (!(solid && solid->elasticity)) values[0] *= ratio_of(material + ".youngs_modulus");
    if (std::holds_alternative<BeamProperty>(property)) values[0] *= ratio_of(name + ".stiffness");
    values[1] *= ratio_of(material + ".density");
    if (std::holds_alternative<ShellProperty>(property)) values[3] *= ratio_of(name + ".thickness");
  }
  for (auto& [parameter, value] : numbers.others) value *= ratio_of(parameter);
  return numbers;
}

/// Whether shells have a stiffness about their normals that changes with them.
bool follows_material(const FiniteElementModel& model, const std::map<std::string, Change>& changes) {
  const auto is_drilling = [](const auto& each) { return each.name.starts_with("drilling"); };
  const bool has_any =
      std::ranges::any_of(model.matrices, is_drilling) || std::ranges::any_of(model.joints, is_drilling);
  return has_any && std::ranges::any_of(changes, [](const auto& change) {
           return change.first.ends_with(".youngs_modulus") || change.first.ends_with(".thickness");
         });
}

/// The folder below which all files stand that are not named by absolute paths.
struct Places {
  fs::path folder;
  std::set<std::string> absolute;  ///< names of files that an INCLUDE states from the root on
};

fs::path full_path(const std::string& name) { return fs::absolute(name).lexically_normal(); }

Places places_of(const Texts& texts, const std::string& main) {
  Places places{full_path(main).parent_path(), {}};
  for (const auto& [name, text] : texts) {
    const bool is_stated = std::ranges::any_of(texts, [&, name = name](const auto& other) {
      return fs::path(name).is_absolute() && other.second.find(name) != std::string::npos;
    });
    if (name != main && is_stated) places.absolute.insert(name);
    if (places.absolute.contains(name)) continue;
    const fs::path path = full_path(name);
    while (path.lexically_relative(places.folder).begin()->string() == "..")
      places.folder = places.folder.parent_path();
  }
  return places;
}

}  // namespace

// How it works:
//   1. the deck is read, and once more its text, field by field;
//   2. every value is asked for as a ratio to the deck's own; what one field states must change alike;
//   3. the changed texts are read again and compared with the model that is meant, number by number.
UpdatedDeck updated_deck(const fs::path& file, const std::vector<DeckValue>& values, const DeckOptions& options,
                         const UnitSystem& units) {
  UpdatedDeck result;
  auto [deck, texts, origins] = read(file, options);
  const std::string main = file.string();
  const auto load = [&texts = texts](const fs::path& path) {
    const auto found = texts.find(path.string());
    return found == texts.end() ? read_text(path) : found->second;
  };
  const std::unique_ptr<DeckText> text = is_of_abaqus(file, options.format)
                                             ? rewriting::abaqus_text(texts.at(main), main, load, origins)
                                             : rewriting::nastran_text(texts.at(main), main, load);
  to_si(deck.model, units);
  Rewriting rewriting(deck.model, units.length, *text, result);
  rewriting.ask_for(values);
  Texts changed = text->apply(result.changes);
  if (changed.empty()) return result;
  const auto places = places_of(texts, main);
  std::string difference;
  for (const auto& [name, content] : changed)
    if (places.absolute.contains(name)) difference = "'" + name + "' is included by its full path";
  if (difference.empty()) {
    auto again = read(file, options, changed).deck;
    to_si(again.model, units);
    difference =
        rewriting::difference(expected_numbers(deck.model, rewriting.changes()), rewriting::numbers_of(again.model));
  }
  if (!difference.empty()) {
    for (const auto& [parameter, change] : rewriting.changes())
      result.unwritten.push_back({change.cause, "the deck with the new fields would be another model: " + difference,
                                  "change the deck by hand"});
    result.changes.clear();
    return result;
  }
  if (follows_material(deck.model, rewriting.changes()))
    result.unwritten.push_back(
        {"stiffness of shells about their normals (K6ROT)",
         "in the deck it follows their material and thickness, the updating held it",
         "compare the deck's modes with those of the updating; if they differ, update once more"});
  for (auto& [name, content] : texts) {
    if (places.absolute.contains(name)) continue;
    const auto relative = full_path(name).lexically_relative(places.folder);
    const auto edited = changed.find(name);
    result.texts[relative] = edited == changed.end() ? std::move(content) : std::move(edited->second);
    if (name == main) result.file = relative;
  }
  return result;
}

fs::path write_deck(const UpdatedDeck& deck, const fs::path& folder) {
  for (const auto& [name, text] : deck.texts) {
    const fs::path place = folder / name;
    std::error_code failure;
    fs::create_directories(place.parent_path(), failure);
    std::ofstream out(place, std::ios::binary);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    if (!out.flush())
      throw InvalidInput("'" + place.string() + "' cannot be written", "the folder or the disk does not allow it",
                         "choose another folder");
  }
  return folder / deck.file;
}

}  // namespace kalfem
