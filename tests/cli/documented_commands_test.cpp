#include <gtest/gtest.h>

#include "command.hpp"

// The commands of docs/questions.md print the line that stands below them.

namespace kalfem::test {
namespace {

struct DocumentedCommand {
  std::string arguments, expected;
};

std::vector<DocumentedCommand> commands_of(const std::string& page) {
  std::vector<DocumentedCommand> commands;
  std::istringstream lines(read(std::string(KALFEM_SOURCE_DIR) + "/docs/" + page));
  const std::string start = "    kalfem ";
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(start)) continue;
    DocumentedCommand command{line.substr(start.size()), ""};
    std::getline(lines, line);
    EXPECT_TRUE(line.starts_with("    ")) << "no expected line below: kalfem " << command.arguments;
    command.expected = line.substr(std::min<std::size_t>(4, line.size()));
    commands.push_back(std::move(command));
  }
  return commands;
}

/// From the project's folder, results elsewhere.
Outcome run_there(const std::string& arguments, const ScratchFolder& folder) {
  const bool writes = !arguments.starts_with("check ") && !arguments.starts_with("inspect ");
  const std::string root = std::string(KALFEM_SOURCE_DIR) + "/";
  std::string text = arguments;
  text.insert(text.find("examples/"), root);
  return run_command(text + (writes ? " --out " + (folder / "out").string() : ""), folder);
}

TEST(DocumentedCommands, PrintWhatThePageSays) {
  const ScratchFolder folder("documented");
  const auto commands = commands_of("questions.md");
  EXPECT_GT(commands.size(), 10u);
  for (const auto& [arguments, expected] : commands) {
    const auto outcome = run_there(arguments, folder);
    EXPECT_TRUE(outcome.code == 0 || outcome.code == 3) << arguments << "\n" << outcome.errors;
    EXPECT_NE((outcome.output + outcome.errors).find(expected), std::string::npos) << arguments << "\n"
                                                                                   << outcome.output << outcome.errors;
  }
}

}  // namespace
}  // namespace kalfem::test
