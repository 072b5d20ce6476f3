// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/formats/measured_file_reader.hpp"
#include "kalfem/report/inspection.hpp"
#include "verbs.hpp"

namespace kalfem::command {

// A file that cannot be read does not hide what the others hold.
ExitCode inspect(const InspectArguments& arguments) {
  const auto& [files, as_json, large, page_file] = arguments;
  if (!page_file.empty()) require_writable(page_file);
  std::vector<Inspection> inspections;
  ExitCode code = done;
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const auto& file : files) {
    try {
      auto inspection = kalfem::inspect(file, read_measured_file(file, {.large = large}));
      if (as_json)
        all.push_back(inspection_json(inspection));
      else
        print_text(inspection_text(inspection));
      if (!page_file.empty()) inspections.push_back(std::move(inspection));
    } catch (const InvalidInput& error) {
      print_error("{}\n", error.what());
      code = mend_the_input;
    }
  }
  if (as_json) print("{}\n", all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  if (!page_file.empty() && !inspections.empty())
    write_file_atomically(page_file, render_html(inspection_page(inspections)));
  return code;
}

}  // namespace kalfem::command
