// SPDX-License-Identifier: Apache-2.0
#include "help.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

namespace kalfem::command {
namespace {

struct Example {
  const char *verb, *line;
};
struct Group {
  const char* title;
  std::vector<Example> examples;
};

/// A verb that is not here stands last, without an example.
const std::vector<Group>& groups() {
  static const std::vector<Group> groups{
      {"Begin",
       {{"new", "kalfem new measured my-case"},
        {"check", "kalfem check my-case/case.yaml"},
        {"inspect", "kalfem inspect record.csv"},
        {"modal", "kalfem modal record.csv --band 0.5 20 --out modes"},
        {"match", "kalfem match test.unv frame.bdf --units mm t s --page match.html"},
        {"schema", "kalfem schema estimate"}}},
      {"Run a case",
       {{"run", "kalfem run my-case/case.yaml --set estimate.smooth=true --out results"},
        {"sweep", "kalfem sweep my-case/case.yaml --seeds 20"}}},
      {"Run one step of it, and what that needs",
       {{"simulate", "kalfem simulate case.yaml --set simulate.duration=4s"},
        {"estimate", "kalfem estimate case.yaml --quiet"},
        {"predict", "kalfem predict case.yaml"},
        {"update", "kalfem update case.yaml --json"},
        {"correlate", "kalfem correlate case.yaml"},
        {"infer", "kalfem infer case.yaml"},
        {"place", "kalfem place case.yaml"},
        {"modes", "kalfem modes frame.bdf --units mm t s"},
        {"static", "kalfem static case.yaml"},
        {"frf", "kalfem frf case.yaml"}}},
      {"Estimate live",
       {{"watch", "kalfem watch live.yaml --log stream.log"},
        {"play", "kalfem play case.yaml --speed 10 --fault dead:a3:10:50"}}},
      {"Look at finished runs",
       {{"report", "kalfem report results"},
        {"compare", "kalfem compare results-1 results-2 --page comparison.html"},
        {"plot", "kalfem plot results --format png"}}},
      {"Set up the shell", {{"completion", "eval \"$(kalfem completion bash)\""}}}};
  return groups;
}

const char* example_of(const std::string& verb) {
  for (const auto& group : groups())
    for (const auto& example : group.examples)
      if (verb == example.verb) return example.line;
  return nullptr;
}

constexpr std::size_t terminal_width = 80;

/// Words behind the beginning of a line, in lines that a terminal holds; the later ones begin at a column.
std::string wrapped(std::string line, std::size_t column, const std::string& text) {
  std::string lines;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (line.size() > column && line.size() + 1 + word.size() > terminal_width) {
      lines += line + "\n";
      line.assign(column, ' ');
    }
    line += (line.empty() || line.back() == ' ' ? "" : " ") + word;
  }
  return lines + line + "\n";
}

/// A name, and beside it from a column on what it means.
std::string entry(const std::string& name, std::size_t column, const std::string& meaning) {
  std::string line = "  " + name, above;
  if (line.size() + 2 > column) {
    above = line + "\n";
    line.clear();
  }
  line.resize(column, ' ');
  return above + wrapped(line, column, meaning);
}

std::string with_example(const VerbUsage& verb) {
  constexpr std::size_t column = 14;
  std::string text = entry(verb.name, column, verb.meaning);
  if (const char* example = example_of(verb.name)) text += std::string(column + 2, ' ') + example + "\n";
  return text;
}

std::string entries(const std::vector<OptionUsage>& options) {
  std::string text;
  for (const auto& option : options)
    text += entry(option.name + (option.value.empty() ? "" : " " + option.value), 26, option.meaning);
  return text;
}

}  // namespace

std::string overview(const std::vector<VerbUsage>& verbs) {
  std::string text =
      "kalfem identifies and updates nonlinear finite-element models of structures\n"
      "from vibration measurements.\n\n"
      "Usage: kalfem VERB ...        kalfem VERB --help says more of a verb\n"
      "       kalfem --version       version, commit and compiler\n";
  for (const auto& group : groups()) {
    text += fmt::format("\n{}\n", group.title);
    for (const auto& example : group.examples)
      for (const auto& verb : verbs)
        if (verb.name == example.verb) text += with_example(verb);
  }
  std::string others;
  for (const auto& verb : verbs)
    if (!example_of(verb.name)) others += with_example(verb);
  return others.empty() ? text : text + "\nOthers\n" + others;
}

std::string help_of(const VerbUsage& verb) {
  std::string usage = "kalfem " + verb.name;
  if (!verb.options.empty()) usage += " [options]";
  std::vector<OptionUsage> arguments = verb.arguments;
  for (auto& argument : arguments) {
    usage += argument.required ? " " + argument.name : " [" + argument.name + "]";
    argument.value.clear();
  }
  std::string text = wrapped("kalfem " + verb.name + ":", 2, verb.meaning) + "\nUsage: " + usage + "\n";
  if (!arguments.empty()) text += "\n" + entries(arguments);
  if (!verb.options.empty()) text += "\nOptions\n" + entries(verb.options);
  if (const char* example = example_of(verb.name)) text += fmt::format("\nExample\n  {}\n", example);
  return text;
}

}  // namespace kalfem::command
