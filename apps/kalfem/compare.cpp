// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/report/finished/comparison_report.hpp"
#include "verbs.hpp"

namespace kalfem::command {

ExitCode compare(const std::vector<std::string>& folders, RunsAre are, bool as_json, const std::string& page_file) {
  if (!page_file.empty()) require_writable(page_file);
  const RunComparison comparison = compare_runs({folders.begin(), folders.end()}, are);
  if (as_json)
    print("{}\n", comparison_json(comparison).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  else
    print_report(comparison_text(comparison));
  for (const auto& warning : comparison.warnings) print_error("warning: {}\n", warning);
  if (!page_file.empty()) write_file_atomically(page_file, render_html(comparison_page(comparison)));
  return done;
}

}  // namespace kalfem::command
