#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem::command {

/// Exit codes of the contract.
/// 1 also where the machine does not take the output: the disk is full, stdout is closed.
enum ExitCode { done = 0, a_bug = 1, cannot_write = 1, mend_the_input = 2, not_usable = 3, interrupted = 130 };

enum class Told { report, verdict, json };  ///< on stdout; warnings and errors go to stderr in any case

struct RunArguments {
  std::string case_file;
  std::string folder;                ///< of the results; empty: <case>.kalfem-out beside the case
  std::vector<std::string> changes;  ///< KEY=VALUE
  Told told = Told::report;
  bool strict = false;  ///< suspicious results are not usable
};

/// run (everything), simulate, estimate, predict, update, infer, place: the steps up to `last`. A case without the
/// section of the step is an error. Asked to stop (stop_question()), it writes what is finished.
ExitCode run(const RunArguments& arguments, Step last);
/// check: validate and explain, run nothing. With a page file, the model check of the substructures goes there too.
ExitCode check(const std::string& case_file, const std::string& page_file);
/// check of a deck alone: its contents, the cards that kalfem ignores, and the model check. `units`: none (SI) or
/// length, mass and time.
ExitCode check_deck(const std::string& file, const std::vector<std::string>& units, const std::string& page_file);
/// inspect: what measured files hold and what is odd about their channels, as text, JSON (one array) or a page.
ExitCode inspect(const std::vector<std::string>& files, bool as_json, const std::string& page_file);
/// schema: the case-file reference as text, all or one section; or as JSON Schema; or the connector laws.
ExitCode schema(bool as_json, bool laws, const std::string& topic);
/// The JSON Schema, for editors.
std::string case_file_schema();
/// new: a commented case with its data in `folder`, where none of its files may be, and the schema for editors.
ExitCode new_case(const std::string& kind, const std::filesystem::path& folder);
std::vector<std::string> starter_kinds();

/// A verb with what a shell completes after it.
struct VerbForCompletion {
  std::string name, meaning;
  std::vector<std::string> options;  ///< "--out"
};

/// completion: the script that bash, zsh or fish reads.
ExitCode completion(const std::string& shell, const std::vector<VerbForCompletion>& verbs);

}  // namespace kalfem::command
