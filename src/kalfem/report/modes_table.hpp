// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/page.hpp"

namespace kalfem {

/// Natural frequencies of every substructure; of a reduced one also the frequency, the modal assurance criterion and
/// the relative residual of every mode that the reduction keeps. The caption says why modes have none of these.
Table modes_table(const Study& study, const StudyResults& results);

/// Natural frequencies of the joined structure; no rows where nothing is joined.
Table joined_modes_table(const Study& study, const StudyResults& results);

/// Both for a terminal.
std::string console_modes(const Study& study, const StudyResults& results);

}  // namespace kalfem
