// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <regex>
#include <set>

#include "command.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"

/// What the tests of the output folder share.
namespace kalfem::test {

/// A chain of three masses that runs in a tenth of a second, with a title.
inline std::string short_case(const std::string& title) {
  return "kalfem: 1\ntitle: " + title + R"(
substructures:
  wheel: {masses: {w: 1.5 kg}, springs: [{from: ground, to: w, stiffness: 20 kN/m}]}
  body: {chain: {masses: 2, mass: 1 kg, stiffness: 30 kN/m}, damping: {modal: 1 %}}
connectors:
  suspension: {from: wheel.w, to: body.1, law: linear, parameters: {k: 5 kN/m, c: 10 N s/m}}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 3 mm, band: [0.5, 30 Hz]}}
sensors:
  a: {acceleration: body.2, noise: 15 %}
simulate: {duration: 0.5 s, sample_rate: 1 kHz, tolerance: 1e-2}
estimate: {unknown: {suspension.k: {initial: 4 kN/m, std: 20 %}}, settle: 0.1 s}
)";
}

inline std::string write_case(const std::filesystem::path& folder, const std::string& name, const std::string& text) {
  std::ofstream(folder / name) << text;
  return (folder / name).string();
}

/// Names of all files in a folder, hidden ones and links too.
inline std::set<std::string> files_of(const std::filesystem::path& folder) {
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (!std::filesystem::is_directory(entry.symlink_status()))
      files.insert(entry.path().lexically_relative(folder).string());
  return files;
}

/// The identity that a piece of text carries behind `mark`.
inline std::string identity_behind(const std::string& text, const std::string& mark) {
  std::smatch found;
  return std::regex_search(text, found, std::regex(mark + "([0-9a-f]{16})")) ? found[1].str() : "none";
}

/// The identity that all files of a folder of results carry; a word that says which one does not.
inline std::string identity_of(const std::filesystem::path& folder) {
  const auto summary = nlohmann::json::parse(read(folder / "summary.json"), nullptr, false);
  if (!summary.is_object()) return "no summary";
  const std::string run = summary.value("run", "");
  if (identity_behind(read(folder / "report.html"), "name=\"kalfem-run\" content=\"") != run) return "another page";
  if (identity_behind(read(folder / "case.resolved.yaml"), "# run ") != run) return "another case";
  const bool identified = std::filesystem::exists(folder / "case.identified.yaml");
  if (identified && identity_behind(read(folder / "case.identified.yaml"), "# run ") != run)
    return "another identified case";
  const bool has_series = std::filesystem::exists(folder / "results.h5");
  if (has_series && Hdf5File::open((folder / "results.h5").string()).text_attribute("/", "run") != run)
    return "other series";
  for (const auto& name : summary.value("files", std::vector<std::string>{}))
    if (!std::filesystem::is_regular_file(folder / name)) return "no " + name;
  return run;
}

}  // namespace kalfem::test
