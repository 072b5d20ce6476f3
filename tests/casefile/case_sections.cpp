// SPDX-License-Identifier: Apache-2.0
#include "casefile/case_sections.hpp"

#include <fstream>
#include <sstream>

#include "kalfem/study/case_study.hpp"
#include "kalfem/yaml/case_reader.hpp"

namespace kalfem::wiring {
namespace {

const ScratchFolder& folder() {
  static const ScratchFolder scratch("wiring");
  return scratch;
}

Sections merged(Sections base, const Sections& changed) {
  for (const auto& [key, text] : changed) base[key] = text;
  return base;
}

}  // namespace

Sections lumped_case(const Sections& changed) {
  return merged({{"kalfem", "1"},
                 {"substructures",
                  "{s: {masses: {a: 2 kg, b: 3 kg}, springs: [{name: k, from: ground, to: a, stiffness: 800 N/m, "
                  "damping: 4 N s/m}]}}"},
                 {"connectors", "{c: {from: s.a, to: s.b, law: linear, parameters: {k: 500 N/m, c: 3 N s/m}}}"},
                 {"excitation", "{f: {force: s.b, sine: {amplitude: 10 N, frequency: 2 Hz}}}"},
                 {"sensors", "{y: {displacement: s.b, noise: 0.1 mm}}"},
                 {"simulate", "{duration: 0.5 s, sample_rate: 100 Hz}"}},
                changed);
}

Sections estimated_case(const Sections& changed) {
  return merged(lumped_case({{"estimate", "{unknown: {c.k: {initial: 400 N/m, std: 100 N/m}}, settle: 0.1 s}"}}),
                changed);
}

std::string beam_elements(const std::string& more, const std::string& section, const std::string& beam_more) {
  write_file("nodes.csv", "node,x_m,y_m,z_m\n1,0,0,0\n2,0.5,0,0\n3,1,0,0\n");
  write_file("elements.csv", "element,node1,node2,region\n1,1,2,bar\n2,2,3,bar\n");
  return "tables: {nodes: nodes.csv, elements: elements.csv}, materials: {steel: {youngs_modulus: 210 GPa, density: "
         "7850 kg/m^3}}, regions: {bar: {material: steel, beam: {section: {" +
         section + "}" + beam_more + "}}}, nodes: {root: 1, mid: 2, tip: 3}, fixed: {clamp: {nodes: root}}" +
         (more.empty() ? "" : ", " + more);
}

Sections beam_case(const Sections& changed) {
  return merged({{"kalfem", "1"},
                 {"substructures", "{b: {finite_elements: {" + beam_elements() + "}}}"},
                 {"excitation", "{f: {force: b.tip.z, sine: {amplitude: 1 N, frequency: 2 Hz}}}"},
                 {"sensors", "{y: {acceleration: b.tip.z, noise: 5 %}}"},
                 {"simulate", "{duration: 0.02 s, sample_rate: 1 kHz, max_substeps: 512, tolerance: 0.05}"}},
                changed);
}

std::filesystem::path write_file(const std::string& name, const std::string& text) {
  std::ofstream(folder() / name, std::ios::binary) << text;
  return folder() / name;
}

Study study_of(const Sections& sections) {
  std::string text;
  for (const auto& [key, value] : sections)
    if (!value.empty()) text += key + ": " + value + "\n";
  const std::string file = (folder() / "case.yaml").string();
  const Environment none = [](const std::string&) { return std::nullopt; };
  return make_study(read_case_text(text, file, description::case_schema(), none), file);
}

std::string csv_of(double rate, const std::map<std::string, std::vector<double>>& columns, double start) {
  std::ostringstream text;
  text.precision(17);
  text << "time";
  for (const auto& [name, values] : columns) text << "," << name;
  text << "\n";
  for (std::size_t k = 0; k < columns.begin()->second.size(); ++k) {
    text << start + static_cast<double>(k) / rate;
    for (const auto& [name, values] : columns) text << "," << values[k];
    text << "\n";
  }
  return text.str();
}

}  // namespace kalfem::wiring
