// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "kalfem/formats/vtu.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/pictures/nodal_translations.hpp"
#include "kalfem/steps/modes/report.hpp"

namespace kalfem {

using Eigen::Index;
using Json = nlohmann::ordered_json;

namespace {

Json reduction_summary(const Superelement& superelement) {
  const auto& error_indicators = superelement.error_indicators;
  Json modes = Json::array();
  for (const auto& mode : error_indicators.modes)
    modes.push_back({{"full_hz", number(mode.full)},
                     {"reduced_hz", number(mode.reduced)},
                     {"mac", number(mode.mac)},
                     {"residual", number(mode.residual)}});
  return {{"dofs", superelement.model.size()},
          {"boundary", superelement.boundary.size()},
          {"reason", error_indicators.reason},
          {"highest_kept_hz", number(error_indicators.highest_kept)},
          {"next_left_out_hz", number(error_indicators.next_left_out)},
          {"static_error", number(error_indicators.static_error)},
          {"modes", modes}};
}

Json vector_json(const Eigen::Vector3d& vector) {
  return Json::array({number(vector[0]), number(vector[1]), number(vector[2])});
}

}  // namespace

Json model_summary(const Study& study, const StudyResults& results) {
  Json parts = Json::object();
  Eigen::Index dofs = 0;
  for (const auto& part : modes_found(results).substructures) {
    Json frequencies = Json::array();
    for (const double f : part.frequencies) frequencies.push_back(number(f));
    parts[part.name] = {{"dofs", part.dofs}, {"mass", number(part.mass)}, {"frequencies_hz", frequencies}};
    if (const auto* updated = updated_modes_of(results, part.name))
      parts[part.name]["updated_frequencies_hz"] = numbers(updated->frequencies);
    dofs += part.dofs;
  }
  for (const auto& elements : study.structure->finite_elements) {
    const auto& part = *elements.part;
    parts[part.name]["moving_mass"] = vector_json(part.moving_mass);
    if (!part.elements.mesh.nodes.isZero(0.0))  // of matrices without coordinates
      parts[part.name]["centre_of_gravity"] = vector_json(part.mass.centre);
  }
  for (const auto& elements : study.structure->finite_elements)
    if (elements.reduced) parts[elements.part->name]["reduction"] = reduction_summary(*elements.reduced);
  Json model = {{"dofs", dofs},
                {"reduced_dofs",
                 study.augmented_model ? study.augmented_model->model->system().size() : study.model->system().size()},
                {"connectors", study.model->system().connector_count()},
                {"substructures", parts}};
  const auto& joined = modes_found(results).joined_frequencies;
  if (joined.size() > 0) model["joined_frequencies_hz"] = numbers(joined);
  return model;
}

void write_modes(const std::filesystem::path& folder, const FiniteElementPart& part, const SubstructureModes& modes,
                 const SubstructureModes* updated) {
  std::vector<NodalField> fields;
  const auto add = [&](const std::string& label, const SubstructureModes& all) {
    for (Index i = 0; i < all.frequencies.size(); ++i)
      fields.push_back({fmt::format("{}mode {:02d}: {:.2f} Hz", label, i + 1, all.frequencies[i]),
                        nodal_translations(part, all.shapes.col(i))});
  };
  if (updated) add("updated ", *updated);
  add(updated ? "initial " : "", modes);
  write_vtu((folder / (part.name + "_modes.vtu")).string(), part.elements.mesh, fields);
}

}  // namespace kalfem
