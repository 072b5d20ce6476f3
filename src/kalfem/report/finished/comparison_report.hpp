// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "kalfem/page/page.hpp"
#include "kalfem/report/finished/run_comparison.hpp"

namespace kalfem {

/// The runs with verdict, filter, NIS and time; the parameters; the agreement of each sensor; the errors of estimated,
/// smoothed and predicted motion and of the validation; the times by step; of members the population, see
/// population_tables(). What a run does not have is a dash; tables
/// without rows are left out.
std::vector<Table> comparison_tables(const RunComparison& comparison);

/// The tables as the command prints them, and a sentence where the cases differ.
std::string comparison_text(const RunComparison& comparison);

/// Every reason of every verdict.
Table verdict_table(const RunComparison& comparison);

/// The comparison for programs, in SI units; null for what a run does not have.
nlohmann::ordered_json comparison_json(const RunComparison& comparison);

/// The tables of a comparison, the identified law and the course of each parameter in all runs, read from their
/// results.h5. Throws InvalidInput if one of these files cannot be read.
Page comparison_page(const RunComparison& comparison);

}  // namespace kalfem
