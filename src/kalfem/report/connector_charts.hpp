#pragma once

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// Force of every connector with an unknown parameter: over deformation at rest and over rate at zero deformation
/// (identified with its 95 % band, and true) where the law has no memory, and the path that it went.
Section connectors_section(const Study& study, const EstimationOutcome& outcome);

}  // namespace kalfem
