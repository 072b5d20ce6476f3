// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/modal/identify_modes.hpp"
#include "kalfem/report/modal_report.hpp"
#include "kalfem/report/output_record.hpp"
#include "verbs.hpp"

namespace kalfem::command {

ExitCode modal(const ModalArguments& arguments) {
  const std::filesystem::path folder = arguments.folder;
  if (!folder.empty()) require_writable(folder / "modes.json");
  if (!arguments.page.empty()) require_writable(arguments.page);
  const auto outputs = read_outputs(arguments.file, arguments.options.channels, arguments.sample_rate);
  ModalOptions options = arguments.options;
  options.channels.clear();  // they are all there is
  if (arguments.band.size() == 2) options.band = FrequencyBand{arguments.band[0], arguments.band[1]};
  auto result = identify_modes(outputs.record, options);
  if (!outputs.left_out.empty())
    result.remarks.push_back(fmt::format("Forces are left out: {}.", fmt::join(outputs.left_out, ", ")));
  const std::string source = std::filesystem::path(arguments.file).filename().string();
  if (!folder.empty()) write_modal_files(folder, source, result, outputs.places);
  if (!arguments.page.empty()) write_file_atomically(arguments.page, render_html(modal_page(source, result)));
  if (arguments.as_json)
    print("{}\n", modal_json(source, result).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  else
    print("{}{}", modal_text(source, result),
          folder.empty() ? "" : fmt::format("\nTables and shapes in {}\n", folder.string()));
  return result.modes.empty() ? not_usable : done;
}

}  // namespace kalfem::command
