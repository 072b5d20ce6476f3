#pragma once

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// The updating on the page: parameters, what they rest on, the course of the search, measured and model responses.
Section updating_section(const Study& study, const StudyResults& results);

}  // namespace kalfem
