#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// Force of every connector with an unknown parameter: over deformation at rest and over rate at zero deformation
/// (identified with its 95 % band, and true) where the law has no memory, and the path that it went.
Section connectors_section(const Study& study, const EstimationOutcome& outcome);

/// The updating on the page: parameters, what they rest on, the course of the search, measured and model responses.
Section updating_section(const Study& study, const StudyResults& results);

/// The entries of a vector, as a series of a chart holds them.
inline std::vector<double> series_values(const Eigen::VectorXd& vector) { return {vector.begin(), vector.end()}; }

}  // namespace kalfem
