// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/part_factors.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Cells = std::vector<Index>;

struct Numbers {
  std::int64_t first = 0, last = 0;
};

/// "17" or "101-250".
std::optional<Numbers> numbers_in(const std::string& text) {
  Numbers numbers;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, numbers.first);
  if (first.ec != std::errc()) return {};
  numbers.last = numbers.first;
  if (first.ptr == end) return numbers;
  if (*first.ptr != '-') return {};
  const auto last = std::from_chars(first.ptr + 1, end, numbers.last);
  return last.ec == std::errc() && last.ptr == end ? std::optional(numbers) : std::nullopt;
}

Cells cells_of_material(const FiniteElementModel& model, const std::string& material) {
  Cells cells;
  for (const auto& [region, property] : model.properties)
    if (material_of(property) == material)
      if (const auto found = model.mesh.regions.find(region); found != model.mesh.regions.end())
        cells.insert(cells.end(), found->second.begin(), found->second.end());
  return cells;
}

Cells cells_numbered(const Mesh& mesh, const Numbers& numbers) {
  Cells cells;
  for (std::size_t i = 0; i < mesh.cells.size(); ++i)
    if (mesh.cells[i].id >= numbers.first && mesh.cells[i].id <= numbers.last) cells.push_back(static_cast<Index>(i));
  return cells;
}

Cells sorted(Cells cells) {
  std::ranges::sort(cells);
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

/// Everything that the name may mean, in words, with its cells.
std::vector<std::pair<std::string, Cells>> meanings(const FiniteElementModel& model, const std::string& name) {
  std::vector<std::pair<std::string, Cells>> all;
  const auto add = [&](const char* kind, Cells cells) {
    if (!cells.empty()) all.emplace_back(kind, sorted(std::move(cells)));
  };
  if (const auto set = model.mesh.element_sets.find(name); set != model.mesh.element_sets.end())
    add("a set of elements", set->second);
  else if (const auto region = model.mesh.regions.find(name); region != model.mesh.regions.end())
    add("a region", region->second);
  add("a material", cells_of_material(model, name));
  if (const auto numbers = numbers_in(name); numbers && all.empty())
    add("numbers of elements", cells_numbered(model.mesh, *numbers));
  return all;
}

std::vector<std::string> known_names(const FiniteElementModel& model) {
  std::set<std::string> names;
  for (const auto& entry : model.mesh.regions) names.insert(entry.first);
  for (const auto& entry : model.mesh.element_sets) names.insert(entry.first);
  for (const auto& entry : model.materials) names.insert(entry.first);
  return {names.begin(), names.end()};
}

/// Cells that have a property, and so are part of the structure.
std::vector<bool> cells_in_use(const FiniteElementModel& model) {
  std::vector<bool> used(model.mesh.cells.size(), false);
  for (const auto& entry : model.properties)
    if (const auto region = model.mesh.regions.find(entry.first); region != model.mesh.regions.end())
      for (const auto cell : region->second) used[static_cast<std::size_t>(cell)] = true;
  return used;
}

void require_new(const FiniteElementModel& model, const std::string& factor) {
  if (std::ranges::find(model.factors, factor, &PartFactor::name) != model.factors.end())
    throw InvalidInput("factor '" + factor + "' is given twice", "each factor is a parameter of its own",
                       "give it another name");
}

}  // namespace

Cells elements_named(const FiniteElementModel& model, const std::string& name) {
  const auto all = meanings(model, name);
  if (all.empty())
    throw InvalidInput("there are no elements '" + name + "'" + did_you_mean(name, known_names(model)),
                       "a factor needs elements to multiply",
                       "name a region, a set of elements, a material, or numbers of elements such as 101-250");
  for (const auto& [kind, cells] : all)
    if (cells != all.front().second)
      throw InvalidInput("'" + name + "' is " + all.front().first + " and " + kind + " with other elements",
                         "it is unclear which ones the factor multiplies", "name the elements by their numbers");
  return all.front().second;
}

void add_element_factor(FiniteElementModel& model, const std::string& factor, const std::vector<std::string>& names,
                        FactorOf of, double value) {
  require_new(model, factor);
  IssueList issues;
  Cells cells;
  for (const auto& name : names) try {
      const Cells own = elements_named(model, name);
      cells.insert(cells.end(), own.begin(), own.end());
    } catch (const InvalidInput& error) {
      issues.add(error, {});
    }
  issues.raise();
  cells = sorted(std::move(cells));
  const auto used = cells_in_use(model);
  std::erase_if(cells, [&](Index cell) { return !used[static_cast<std::size_t>(cell)]; });
  if (cells.empty())
    throw InvalidInput("factor '" + factor + "' has no element that is part of the model", "it would have no effect",
                       "name elements that have a property");
  model.factors.push_back({factor, value, std::move(cells), of});
}

void add_matrix_factor(FiniteElementModel& model, const std::string& factor, NodalMatrices matrices, double value) {
  require_new(model, factor);
  matrices.name = matrices.factor = factor;
  model.matrices.push_back(std::move(matrices));
  model.factors.push_back({factor, value});
}

std::vector<double> factors_of_cells(const FiniteElementModel& model, FactorOf what) {
  if (model.factors.empty()) return {};
  std::vector<double> products(model.mesh.cells.size(), 1.0);
  for (const auto& factor : model.factors)
    if (factor.of == what || factor.of == FactorOf::both)
      for (const auto cell : factor.cells) products[static_cast<std::size_t>(cell)] *= factor.value;
  return products;
}

}  // namespace kalfem
