#pragma once

#include <string>
#include <vector>

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem::command {

/// Exit codes of the contract.
/// 1 also where the machine does not take the output: the disk is full, stdout is closed.
enum ExitCode { done = 0, a_bug = 1, cannot_write = 1, mend_the_input = 2, not_usable = 3 };

/// run (everything), simulate, estimate, predict, update, infer, place: the steps up to `last`, results into `folder`
/// (empty: <case>.kalfem-out beside it). A case without the section of the step is an error.
ExitCode run(const std::string& case_file, Step last, const std::string& folder, bool strict);
/// check: validate and explain, run nothing. With a page file, the model check of the substructures goes there too.
ExitCode check(const std::string& case_file, const std::string& page_file);
/// check of a deck alone: its contents, the cards that kalfem ignores, and the model check. `units`: none (SI) or
/// length, mass and time.
ExitCode check_deck(const std::string& file, const std::vector<std::string>& units, const std::string& page_file);
/// inspect: what measured files hold and what is odd about their channels, as text, JSON (one array) or a page.
ExitCode inspect(const std::vector<std::string>& files, bool as_json, const std::string& page_file);
/// schema: the case-file reference as text, or as JSON Schema, or the connector laws.
ExitCode schema(bool as_json, bool laws);

}  // namespace kalfem::command
