#pragma once

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// report.html's content: the answer first, then convergence of the parameters, motion against the reference, the
/// identified connectors, the prediction, and whether the innovations are what they should be.
Page make_page(const Study& study, const StudyResults& results);

}  // namespace kalfem
