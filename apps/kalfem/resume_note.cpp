// SPDX-License-Identifier: Apache-2.0
#include "resume_note.hpp"

#include <nlohmann/json.hpp>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/hash.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/steps/table.hpp"

namespace kalfem::command {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string hash_of(const std::string& text) {
  Hash hash;
  hash.add(text);
  return std::to_string(hash.value());
}

[[noreturn]] void fail(const fs::path& place, const std::string& what, const std::string& why, const std::string& fix) {
  throw InvalidInput(Issue{{place.string(), 0}, what, why, fix});
}

}  // namespace

ResumeNote::ResumeNote(const fs::path& folder, const RunArguments& arguments, std::string_view verb,
                       const std::string& resolved_case)
    : file_(folder / file_name) {
  const Json note{{"kalfem", version},          {"case", fs::absolute(arguments.case_file).lexically_normal().string()},
                  {"last_step", verb},          {"set", arguments.changes},
                  {"strict", arguments.strict}, {"case_hash", hash_of(resolved_case)}};
  write_file_atomically(file_, note.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

ResumeNote::~ResumeNote() {
  std::error_code ignored;
  if (!stays_) fs::remove(file_, ignored);
}

void NotedRun::require_same_case(const std::string& resolved_case) const {
  if (hash_of(resolved_case) != case_hash)
    fail(arguments.case_file, "the case has changed since the run that is to be resumed", "its results would be mixed",
         "start a new run of the case");
}

NotedRun read_resume_note(const fs::path& folder) {
  const fs::path file = folder / ResumeNote::file_name;
  if (std::error_code error; !fs::is_regular_file(file, error))
    fail(folder, "it holds no interrupted run", std::string(ResumeNote::file_name) + " is missing",
         "give the folder of the results of a run that was stopped or killed, or run the case");
  const Json note = Json::parse(read_bytes(file), nullptr, false);
  try {
    if (note.at("kalfem") != version)
      fail(file, "the run was started by kalfem " + note.at("kalfem").dump(), "this is kalfem " + std::string(version),
           "run the case again");
    NotedRun run;
    run.arguments.case_file = note.at("case");
    run.arguments.folder = folder.string();
    run.arguments.changes = note.at("set").get<std::vector<std::string>>();
    run.arguments.strict = note.at("strict");
    run.case_hash = note.at("case_hash");
    run.verb = note.at("last_step");
    if (run.verb != every_step && !find_step(run.verb)) throw Json::other_error::create(501, "step", &note);
    return run;
  } catch (const Json::exception&) {
    fail(file, "it is damaged", "", "run the case again");
  }
}

}  // namespace kalfem::command
