#include "kalfem/formats/universal/universal.hpp"

#include <charconv>
#include <map>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

bool is_mark(std::string_view line) { return trimmed(line) == "-1"; }

/// The number in a dataset's first line, -1 where it holds none.
int number_of(std::string_view line) {
  const std::string_view text = trimmed(line);
  int number = -1;
  return std::from_chars(text.data(), text.data() + text.size(), number).ec == std::errc() ? number : -1;
}

}  // namespace

bool begins_universal(std::string_view head) {
  const auto lines = content_lines(head);
  return lines.size() > 1 && lines[0].text.starts_with("    -1") && is_mark(lines[0].text) &&
         number_of(lines[1].text) > 0;
}

MeasuredFile read_universal(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  const auto lines = content_lines(text);
  if (lines.size() < 2 || !is_mark(lines[0].text) || number_of(lines[1].text) <= 0)
    throw InvalidInput(Issue{{file.string(), 1},
                             "this is not a universal file",
                             "it must begin with a line '    -1' and a line with the number of a dataset",
                             "export it again"});
  MeasuredFile measured{.format = "universal file"};
  std::map<int, int> skipped;
  bool inside = false;
  int number = -1;
  for (const auto& line : lines) {
    if (is_mark(line.text)) {
      if (inside) ++skipped[number];
      inside = !inside;
      number = -1;
    } else if (inside && number < 0) {
      number = number_of(line.text);
    }
  }
  for (const auto& [dataset, count] : skipped)
    measured.skipped.push_back("dataset " + std::to_string(dataset) + " (" + std::to_string(count) +
                               " times) is not read");
  return measured;
}

}  // namespace kalfem
