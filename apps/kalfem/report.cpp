// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/console_report.hpp"
#include "kalfem/report/finished/finished_report.hpp"
#include "kalfem/steps/compared.hpp"

#include "console.hpp"
#include "verbs.hpp"

namespace kalfem::command {

ExitCode report(const std::string& folder, bool as_json) {
  const FinishedRun run = read_finished_run(folder);
  if (as_json)
    print_text(run.summary);
  else
    print_report(console_report(run));
  if (!as_json)
    print_verdict(run.compared ? std::optional(run.verdict) : std::nullopt, why_no_verdict(!run.correlation.empty()));
  if (!run.usable) print_error("the numbers are not usable: {}\n", run.message);
  for (const auto& warning : run.warnings) print_error("warning: {}\n", warning);
  return run.usable ? done : not_usable;
}

}  // namespace kalfem::command
