// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/scratch_folder.hpp"
#include "kalfem/study/study.hpp"

/// Small cases made of sections of text, for tests of what is built from a case file.
namespace kalfem::wiring {

/// Top-level keys of a case with their text: {"simulate", "{duration: 1 s, sample_rate: 100 Hz}"}. A text that is empty
/// leaves the section out.
using Sections = std::map<std::string, std::string>;

/// Two masses of 2 and 3 kg, a spring to the ground, a linear connector between them, a force and one sensor; 0.5 s.
Sections lumped_case(const Sections& changed = {});
/// The same with an `estimate` of the connector's stiffness.
Sections estimated_case(const Sections& changed = {});
/// A cantilever of two beams along x, of tables in the test's folder, with a force and an accelerometer at its tip.
Sections beam_case(const Sections& changed = {});
/// Finite elements of `beam_case` as one section, with more keys: beam_elements("masses: {...}").
std::string beam_elements(const std::string& more = "", const std::string& section = "circle: {diameter: 20 mm}",
                          const std::string& beam_more = "");

/// Writes a file into the folder that the cases of this test stand in and returns its path.
std::filesystem::path write_file(const std::string& name, const std::string& text);

/// Reads and understands the case. Throws InvalidInput.
Study study_of(const Sections& sections);

/// Column of a table "name: values" of a CSV file with a time column at `rate`.
std::string csv_of(double rate, const std::map<std::string, std::vector<double>>& columns, double start = 0.0);

/// How the value of a key is checked; the name of the key is that of the schema.
using KeyChecks = std::map<std::string, std::function<void()>>;
KeyChecks structure_keys();
KeyChecks finite_element_keys();
KeyChecks component_keys();
KeyChecks excitation_keys();
KeyChecks sensor_and_record_keys();
KeyChecks live_keys();
KeyChecks simulation_keys();
KeyChecks estimation_keys();
KeyChecks updating_keys();
KeyChecks compared_response_keys();
/// A part of what `deviation` of a comparison is looked at by.
void frequency_responses_of_tables();
KeyChecks inference_keys();
KeyChecks report_keys();
KeyChecks placement_keys();
KeyChecks static_keys();
KeyChecks frequency_response_keys();

}  // namespace kalfem::wiring
