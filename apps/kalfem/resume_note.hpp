// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "verbs.hpp"

namespace kalfem::command {

/// What `kalfem run --resume DIR` needs to know of an interrupted run: a small file in its folder, there from the start
/// of the run until it has ended. A process that is killed leaves it.
class ResumeNote {
public:
  static constexpr const char* file_name = "run.resume.json";

  /// Writes the note. Throws as write_file_atomically().
  ResumeNote(const std::filesystem::path& folder, const RunArguments& arguments, std::string_view verb,
             const std::string& resolved_case);
  ResumeNote(const ResumeNote&) = delete;
  ResumeNote& operator=(const ResumeNote&) = delete;
  /// Removes it unless it is to stay.
  ~ResumeNote();

  void stay() { stays_ = true; }

private:
  std::filesystem::path file_;
  bool stays_ = false;
};

/// A run as it was started: verb, case, changes, and a hash of the case with all its defaults.
struct NotedRun {
  RunArguments arguments;
  std::string verb = std::string(every_step);
  std::string case_hash;

  /// Throws InvalidInput if this is not the case as it was.
  void require_same_case(const std::string& resolved_case) const;
};

/// The interrupted run of a folder. Throws InvalidInput if it holds none, or one of another version.
NotedRun read_resume_note(const std::filesystem::path& folder);

}  // namespace kalfem::command
