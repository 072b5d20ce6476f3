// SPDX-License-Identifier: Apache-2.0
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/interruption.hpp"
#include "kalfem/page/chart_svg.hpp"
#include "kalfem/report/finished/run_figures.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

namespace fs = std::filesystem;

constexpr const char* converter = "rsvg-convert";
constexpr const char* dots_per_inch = "300";

/// Exit code of a program with these arguments; nothing if it cannot be started.
std::optional<int> run_program(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  if (posix_spawnp(&child, arguments.front(), nullptr, nullptr, arguments.data(), environ) != 0) return std::nullopt;
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return std::nullopt;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

[[noreturn]] void fail_without_converter() {
  throw InvalidInput("--format png: the program " + std::string(converter) + " is missing",
                     "it turns the figures into PNG", "apt install librsvg2-bin, or use --format svg");
}

bool is_installed(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::string folders = path ? path : "";
  for (std::size_t begin = 0; begin <= folders.size();) {
    const std::size_t end = std::min(folders.find(':', begin), folders.size());
    if (access((fs::path(folders.substr(begin, end - begin)) / program).c_str(), X_OK) == 0) return true;
    begin = end + 1;
  }
  return false;
}

/// Two columns are low and wide, one column is nearly as high as a golden section.
FigureSize size_of(double width) { return {.width = width, .height = (width > 12.0 ? 0.4 : 0.65) * width}; }

void write_png(const fs::path& file, const std::string& svg) {
  const fs::path drawing = fs::path(file).replace_extension(".svg" + std::string(temporary_ending));
  write_file_atomically(drawing, svg);
  const auto code = run_program({converter, "--dpi-x", dots_per_inch, "--dpi-y", dots_per_inch, "--format", "png",
                                 "--output", file.string(), drawing.string()});
  std::error_code ignored;
  fs::remove(drawing, ignored);
  if (!code) fail_without_converter();
  if (*code != 0)
    throw InvalidInput(file.string() + ": " + converter + " failed with exit code " + std::to_string(*code), "",
                       "use --format svg");
}

}  // namespace

ExitCode plot(const PlotArguments& arguments) {
  const bool png = arguments.format == "png";
  if (png && !is_installed(converter)) fail_without_converter();
  const FinishedRun run = read_finished_run(arguments.folder);
  const auto figures = run_figures(run, arguments.points);
  if (figures.empty())
    throw InvalidInput(arguments.folder + ": there is nothing to plot", "the run followed no parameter and no motion",
                       "run the case with `estimate`, `update` or `validate`");
  const fs::path folder =
      arguments.output.empty() ? fs::path(arguments.folder) / "figures" : fs::path(arguments.output);
  for (const auto& [name, chart] : figures) {
    stop_if_asked();
    const fs::path file = folder / (name + "." + arguments.format);
    const std::string svg = chart_svg(chart, size_of(arguments.width));
    if (png)
      write_png(file, svg);
    else
      write_file_atomically(file, svg);
    print("{}\n", file.string());
  }
  return done;
}

}  // namespace kalfem::command
