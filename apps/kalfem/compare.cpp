// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/report/finished/comparison_report.hpp"
#include "verbs.hpp"

namespace kalfem::command {

ExitCode compare(const std::vector<std::string>& folders, bool as_json, const std::string& page_file) {
  if (folders.size() < 2)
    throw InvalidInput("compare: one folder given", "a comparison needs at least two",
                       "give the folders of two or more runs; `kalfem report` shows a single one");
  if (!page_file.empty()) require_writable(page_file);
  const RunComparison comparison = compare_runs({folders.begin(), folders.end()});
  if (as_json)
    print("{}\n", comparison_json(comparison).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  else
    for (const auto& table : comparison_tables(comparison)) print_report(table.title + "\n" + to_text(table) + "\n");
  if (!as_json && !comparison.differences.empty()) print("{}\n", comparison.differences);
  for (const auto& warning : comparison.warnings) print_error("warning: {}\n", warning);
  if (!page_file.empty()) write_file_atomically(page_file, render_html(comparison_page(comparison)));
  return done;
}

}  // namespace kalfem::command
