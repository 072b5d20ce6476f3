#include "kalfem/report/field_files.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "kalfem/formats/vtu.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;
using Eigen::Index;

/// Translations of all nodes, 3 x nodes, from the free degrees of freedom.
Eigen::MatrixXd translations(const FiniteElementPart& part, const Eigen::VectorXd& displacement) {
  const Eigen::VectorXd all = part.assembled.expansion * displacement;
  return all.reshaped(6, part.elements.mesh.node_count()).topRows(3);
}

void write_modes(const fs::path& folder, const FiniteElementPart& part, const SubstructureModes& modes) {
  std::vector<NodalField> fields;
  for (Index i = 0; i < modes.frequencies.size(); ++i)
    fields.push_back(
        {fmt::format("mode {:02d}: {:.2f} Hz", i + 1, modes.frequencies[i]), translations(part, modes.shapes.col(i))});
  write_vtu((folder / (part.name + "_modes.vtu")).string(), part.elements.mesh, fields);
}

void write_series(const fs::path& folder, const FiniteElementPart& part, const FieldSeries& series) {
  std::vector<SeriesEntry> entries;
  for (std::size_t k = 0; k < series.times.size(); ++k) {
    const std::string file = fmt::format("{}/{:05d}.vtu", series.name, k);
    write_vtu((folder / file).string(), part.elements.mesh,
              {{"displacement", translations(part, series.displacement.col(static_cast<Index>(k)))}});
    entries.push_back({series.times[k], file});
  }
  write_pvd((folder / (series.name + ".pvd")).string(), entries);
}

}  // namespace

void write_fields(const std::string& folder, const Study& study, const StudyResults& results) {
  for (const auto& elements : study.structure->finite_elements) {
    if (elements.part->elements.mesh.cells.empty()) continue;
    for (const auto& modes : results.modes)
      if (modes.name == elements.part->name) write_modes(folder, *elements.part, modes);
    for (const auto& series : results.fields)
      if (series.substructure == elements.part->name) write_series(folder, *elements.part, series);
  }
}

}  // namespace kalfem
