// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/universal/universal.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <vector>

#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/formats/universal/dataset_readers.hpp"
#include "kalfem/formats/universal/fields.hpp"
#include "kalfem/formats/universal/function_header.hpp"

namespace kalfem {
namespace {

/// The number of a dataset's identifier "    58" or "    58b ...", 0 where it is none.
int dataset_number(std::string_view line) {
  const auto words = words_of(line);
  if (words.empty() || words.front().size() > 7) return 0;
  std::string_view digits = words.front();
  if (digits.ends_with('b') || digits.ends_with('B')) digits.remove_suffix(1);
  if (digits.empty() || digits.find_first_not_of("0123456789") != std::string_view::npos) return 0;
  return static_cast<int>(*universal_integer(digits));
}

constexpr int functions = 58;  ///< the dataset that its counts of samples close too
constexpr int units = 164;

/// How datasets are read, by their numbers.
const std::map<int, void (*)(UniversalReading&)>& readers() {
  static const std::map<int, void (*)(UniversalReading&)> all = {
      {15, read_nodes_15},     {55, read_data_at_nodes}, {functions, read_function}, {82, read_trace_line},
      {151, read_header},      {units, read_units},      {780, read_elements},       {781, read_nodes_2411},
      {2411, read_nodes_2411}, {2412, read_elements},    {2414, read_analysis_data},
  };
  return all;
}

/// Passes over the rest of the dataset. The bytes of an unknown binary one are counted in its identifier.
void pass_over(UniversalReading& reading) {
  if (is_binary(reading.identifier)) {
    const BinaryForm form = binary_form(reading.identifier);
    for (long line = 0; line < std::clamp(form.text_lines, 0L, 100L); ++line) reading.line("a line of text");
    if (form.bytes <= reading.source.bytes_left()) reading.source.take(form.bytes);
  }
  while (reading.next_line() != nullptr) continue;
}

/// The datasets of a file, in their order. Problems are gathered, and reading goes on after the next mark, but not
/// after damaged bytes, among which marks cannot be told.
class UniversalReader {
public:
  UniversalReader(UniversalSource source, const std::string& name)
      : source_(std::move(source)), problems_(name), reading_{.source = source_, .file = file_} {
    file_.format = "universal file";
  }

  MeasuredFile read() {
    read_datasets();
    if (late_units_) read_again(*late_units_);
    finish();
    return std::move(file_);
  }

private:
  void read_datasets() {
    bool closed = false;  // a mark that closes a dataset opens the next one where its own mark is missing
    while (source_.next()) {
      const std::string_view text = trimmed(source_.line());
      if (text.empty()) continue;
      const int number = closed ? dataset_number(text) : 0;
      closed = false;
      if (is_universal_mark(source_.line()) || text == "-1")
        closed = find_dataset();
      else if (number > 0)
        closed = read_dataset(number);
      else
        note_outside();
      if (damaged_) break;
    }
  }

  /// Units that stand behind data hold for these too.
  void read_again(const UniversalUnits& stated) {
    source_.rewind();
    file_ = {.format = "universal file"};
    problems_ = FileProblems(problems_.file());
    skipped_.clear();
    datasets_ = outside_ = first_outside_ = 0;
    reading_.units = stated;
    reading_.local_axes = false;
    reading_.contradicts.clear();
    read_datasets();
    file_.notes.push_back(problems_.file() +
                          ": dataset 164 stands behind data; its units are taken for the whole file");
  }

  /// From a mark on. Whether a dataset was read.
  bool find_dataset() {
    const int mark = source_.number();
    while (source_.next()) {  // a further mark opens the next dataset: this one closed another
      if (trimmed(source_.line()).empty() || is_universal_mark(source_.line())) continue;
      if (const int number = dataset_number(source_.line())) return read_dataset(number);
      note_outside();
      return false;
    }
    file_.skipped.push_back("line " + std::to_string(mark) + ": no dataset follows the mark, the file ends");
    return false;
  }

  bool read_dataset(int number) {
    ++datasets_;
    reading_.identifier = source_.line();
    reading_.begin = source_.number();
    read_known(number);
    return true;
  }

  void read_known(int number) try {
    const auto reader = readers().find(number);
    if (reader != readers().end()) {
      reader->second(reading_);
      if (number == functions) take_end_mark();
      if (number == units) look_for_late_units();
    } else {
      ++skipped_[number];
      pass_over(reading_);
    }
  } catch (const InvalidInput& error) {
    for (const auto& issue : error.issues())
      problems_.add(
          issue.location.line,
          "dataset " + std::to_string(number) + " (from line " + std::to_string(reading_.begin) + "): " + issue.what,
          issue.why, issue.fix);
    damaged_ = is_binary(reading_.identifier);
    while (!damaged_ && source_.next())
      if (is_universal_mark(source_.line())) break;
  }

  void look_for_late_units() {
    const bool data =
        !file_.channels.empty() || !file_.functions.empty() || !file_.shapes.empty() || !file_.nodes.empty();
    if (!has_units_ && data && !reading_.units.si()) late_units_ = reading_.units;
    has_units_ = true;
  }

  /// Behind the samples of a function, where the mark may be missing.
  void take_end_mark() {
    while (source_.next()) {
      if (trimmed(source_.line()).empty()) continue;
      if (!is_universal_mark(source_.line())) source_.put_back();
      break;
    }
  }

  void note_outside() {
    if (outside_++ == 0) first_outside_ = source_.number();
  }

  void finish() {
    if (datasets_ == 0)
      problems_.add(1, "this is not a universal file",
                    "it must hold datasets, each between two lines '    -1' and with its number first",
                    "export it again");
    problems_.raise();
    for (const auto& [number, count] : skipped_)
      file_.skipped.push_back("dataset " + std::to_string(number) + " is not read" +
                              (count > 1 ? " (" + std::to_string(count) + " times)" : ""));
    if (outside_ > 0)
      file_.skipped.push_back("line " + std::to_string(first_outside_) + ": " + std::to_string(outside_) +
                              " lines outside of datasets are not read");
    if (reading_.local_axes)
      file_.skipped.push_back(
          "local axes of nodes are not used: the directions of functions and shapes at such nodes are those of the "
          "file");
    if (!reading_.contradicts.empty())
      file_.skipped.push_back("the units of dataset 164 are not used where a label names another one, as that of '" +
                              reading_.contradicts + "'");
    make_unique(file_.channels);
    make_unique(file_.functions);
  }

  /// Repeated names get numbers, "12:+Z #1", "12:+Z #2", so that the name alone chooses none of them.
  template <typename Measured>
  static void make_unique(std::vector<Measured>& all) {
    std::map<std::string, int> total, used;
    for (const auto& each : all) ++total[each.name];
    for (auto& each : all) {
      if (total[each.name] == 1) continue;
      each.other_names.insert(each.other_names.begin(), each.name);
      each.name += " #" + std::to_string(++used[each.name]);
    }
  }

  UniversalSource source_;
  MeasuredFile file_;
  FileProblems problems_;
  UniversalReading reading_;
  std::map<int, int> skipped_;
  int datasets_ = 0, outside_ = 0, first_outside_ = 0;
  bool damaged_ = false, has_units_ = false;
  std::optional<UniversalUnits> late_units_;
};

}  // namespace

const std::string& UniversalReading::line(const std::string& wanted) {
  if (!source.next())
    throw source.problem("the file ends before " + wanted, "it is truncated", "copy or export it again");
  if (is_universal_mark(source.line())) {
    source.put_back();
    throw source.problem("the dataset ends before " + wanted, "it is incomplete", "export the file again");
  }
  return source.line();
}

const std::string* UniversalReading::next_line() {
  if (!source.next())
    throw source.problem("the file ends within the dataset", "no end mark '    -1' closes it: the file is truncated",
                         "copy or export it again");
  return is_universal_mark(source.line()) ? nullptr : &source.line();
}

bool begins_universal(std::string_view head) {
  const auto lines = split_lines(head);
  const auto first = std::ranges::find_if(lines, [](const TextLine& line) { return !trimmed(line.text).empty(); });
  if (first == lines.end() || first + 1 == lines.end()) return false;
  return first->text.starts_with("    -1") && is_universal_mark(first->text) && dataset_number((first + 1)->text) > 0;
}

MeasuredFile read_universal(const std::filesystem::path& file) {
  return UniversalReader(UniversalSource(file), file.string()).read();
}

MeasuredFile parse_universal(std::string content, const std::string& source) {
  return UniversalReader(UniversalSource(std::move(content), source), source).read();
}

}  // namespace kalfem
