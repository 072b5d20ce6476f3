#include <algorithm>

#include "kalfem/formats/abaqus/fields.hpp"
#include "kalfem/formats/abaqus/point_elements.hpp"

namespace kalfem::abaqus {

namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Entries of one file over the degrees of freedom that occur in any.
class MatrixFile {
public:
  MatrixFile(PlacedDeck& deck, std::map<NodalDof, int>& columns) : deck_(deck), columns_(columns) {}

  Triplets read(const std::string& text, const Where& where, const std::string& what);

private:
  std::optional<int> column(std::string_view node, std::string_view direction);

  PlacedDeck& deck_;
  std::map<NodalDof, int>& columns_;
};

std::optional<int> MatrixFile::column(std::string_view node, std::string_view direction) {
  const auto label = to_label(node), d = to_integer(direction);
  if (!label || !d || *d < 1 || *d > 6) return {};
  const auto index = deck_.place(0).nodes.find(*label);
  if (index < 0) return {};
  return columns_.try_emplace(NodalDof{index, static_cast<int>(*d) - 1}, static_cast<int>(columns_.size()))
      .first->second;
}

Triplets MatrixFile::read(const std::string& text, const Where& where, const std::string& what) {
  Triplets entries;
  std::string_view rest = text;
  for (int number = 1; !rest.empty(); ++number) {
    const auto end = rest.find('\n');
    const auto line = trimmed_field(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (line.empty() || line.front() == '*') continue;
    const auto fields = split_fields(line);
    const auto row = fields.size() >= 5 ? column(fields[0], fields[1]) : std::nullopt;
    const auto col = fields.size() >= 5 ? column(fields[2], fields[3]) : std::nullopt;
    const auto value = fields.size() >= 5 ? to_number(fields[4]) : std::nullopt;
    if (!row || !col || !value) {
      deck_.problems.add(where, "line " + std::to_string(number) + " of the " + what + " file cannot be read",
                         "a line is: node, direction, node, direction, value", "mend the line");
      return {};
    }
    entries.emplace_back(*row, *col, *value);
    if (*row != *col) entries.emplace_back(*col, *row, *value);
  }
  return entries;
}

}  // namespace

void add_matrices(const RawDeck& raw, PlacedDeck& deck, FiniteElementModel& model) {
  for (const auto& matrix : raw.matrices) {
    std::map<NodalDof, int> columns;
    MatrixFile file(deck, columns);
    const Triplets stiffness = file.read(matrix.stiffness, matrix.where, "stiffness");
    const Triplets mass = file.read(matrix.mass, matrix.where, "mass");
    NodalMatrices result;
    result.name = matrix.name.empty() ? "matrix." + std::to_string(matrix.where.line) : matrix.name;
    result.dofs.resize(columns.size());
    for (const auto& [dof, column] : columns) result.dofs[static_cast<std::size_t>(column)] = dof;
    const auto size = static_cast<Index>(columns.size());
    const auto fill = [&](const Triplets& entries, Eigen::SparseMatrix<double>& target) {
      if (entries.empty()) return;
      target.resize(size, size);
      target.setFromTriplets(entries.begin(), entries.end());
    };
    fill(stiffness, result.stiffness);
    fill(mass, result.mass);
    if (size > 0) model.matrices.push_back(std::move(result));
  }
}

}  // namespace kalfem::abaqus
