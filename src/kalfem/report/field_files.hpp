#pragma once

#include <string>

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// For ParaView: <substructure>_modes.vtu with the modes of each finite-element substructure, and for each field series
/// <name>.pvd with a folder <name>/ of one .vtu a time.
void write_fields(const std::string& folder, const Study& study, const StudyResults& results);

}  // namespace kalfem
