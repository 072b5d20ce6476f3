// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <optional>

#include <string_view>

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/progress.hpp"
#include "kalfem/verdict/verdict.hpp"

namespace kalfem::command {

/// The standard streams as the command uses them. Control characters of titles, names and messages never reach a
/// terminal (`terminal_safe`). Where the reader of a pipe has gone the rest of the text is dropped, as it is meant.

/// Before all else: what is closed of the standard streams is opened onto /dev/null, so that no file of the results
/// takes its number; writing past a size limit or into a broken pipe is an error of the call, not the end of the
/// process.
void prepare_streams();

/// Text to stdout. A failure is kept for require_output().
void print_text(std::string_view text);
/// Whether a person reads stdout while the command runs.
bool is_read_on_terminal();
/// Text to stderr.
void print_error_text(std::string_view text);

template <class... Values>
void print(fmt::format_string<Values...> format, Values&&... values) {
  print_text(fmt::format(format, std::forward<Values>(values)...));
}
template <class... Values>
void print_error(fmt::format_string<Values...> format, Values&&... values) {
  print_error_text(fmt::format(format, std::forward<Values>(values)...));
}

/// A report with tables to stdout; on a terminal the heads of the tables are bold. NO_COLOR switches all styles off.
void print_report(std::string_view text);
/// "Verdict: consistent", on a terminal in the colour of the state.
void print_verdict(std::optional<VerdictState> state,
                   const std::string& why_none = "nothing was compared with measurements");

/// Whether the reader of stdout has gone.
bool reader_has_gone();
/// Throws WriteFailure where stdout did not take the text up to here.
void require_output();

/// Progress of the whole job, which begins now: a bar on a terminal's stderr once it has run for a second. Without a
/// terminal, `in_lines`: a line on stdout for each tenth of a job that runs longer than five seconds.
Progress progress_bar(bool in_lines);

/// From now on SIGINT and SIGTERM ask the command to stop; the second one ends it at once. A signal that the caller has
/// switched off stays so.
void listen_to_signals();
/// Whether one of them came. For StopScope.
const StopQuestion& stop_question();

}  // namespace kalfem::command
