// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "kalfem/base/version.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

/// A backslash begins an escape of troff; a hyphen would become a typographic one, and a line that starts with a dot or
/// a quote would be a request.
std::string in_troff(const std::string& text) {
  std::string safe = text.starts_with('.') || text.starts_with('\'') ? "\\&" : "";
  for (const char c : text)
    if (c == '\\')
      safe += "\\e";
    else if (c == '-')
      safe += "\\-";
    else
      safe += c;
  return safe;
}

std::string bold(const std::string& text) { return "\\fB" + in_troff(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + in_troff(text) + "\\fR"; }

/// "kalfem run [options] case".
std::string synopsis_of(const VerbUsage& verb) {
  std::string line = bold("kalfem " + verb.name);
  if (!verb.options.empty()) line += " [" + italic("options") + "]";
  for (const auto& argument : verb.arguments) line += " " + italic(argument.name);
  return line;
}

std::string item(const std::string& head, const std::string& meaning) {
  return ".TP\n" + head + "\n" + in_troff(meaning) + "\n";
}

std::string verb_section(const VerbUsage& verb) {
  std::string text = fmt::format(".SS {}\n{}.\n", in_troff(verb.name), in_troff(verb.meaning));
  for (const auto& argument : verb.arguments) text += item(italic(argument.name), argument.meaning);
  for (const auto& option : verb.options)
    text += item(bold(option.name) + (option.value.empty() ? "" : " " + italic(option.value)), option.meaning);
  return text;
}

constexpr const char* exit_codes[][2] = {{"0", "done"},
                                         {"1", "an error of kalfem, or the output could not be written"},
                                         {"2", "the input has mistakes; each is named with its place and its remedy"},
                                         {"3", "the numbers are not usable; with --strict also if they are suspicious"},
                                         {"130", "interrupted"}};

constexpr const char* files[][2] = {{"summary.json", "all results, in SI units"},
                                    {"report.html", "the report as a page"},
                                    {"results.h5", "every time series"},
                                    {"case.resolved.yaml", "the case with all its defaults"},
                                    {"case.identified.yaml", "the case with the estimates in it"}};

}  // namespace

std::string manual_page(const std::vector<VerbUsage>& verbs) {
  std::string text = fmt::format(
      ".TH KALFEM 1 \"\" \"kalfem {}\" \"User Commands\"\n.SH NAME\nkalfem \\- identify and update nonlinear "
      "finite\\-element models from vibration measurements\n.SH SYNOPSIS\n",
      version);
  for (std::size_t i = 0; i < verbs.size(); ++i) text += (i > 0 ? ".br\n" : "") + synopsis_of(verbs[i]) + "\n";
  text += ".SH VERBS\n";
  for (const auto& verb : verbs) text += verb_section(verb);
  text += ".SH FILES\nThe folder of the results, <case>.kalfem\\-out or that of \\-\\-out, holds:\n";
  for (const auto& [name, meaning] : files) text += item(italic(name), meaning);
  text += ".SH ENVIRONMENT\n" + item(bold("NO_COLOR"), "if it is set and not empty, nothing is printed in colour");
  text += item(bold("NAME"), "any variable: ${NAME:-default} in a case file stands for its value");
  text += ".SH EXIT STATUS\n";
  for (const auto& [code, meaning] : exit_codes) text += item(bold(code), meaning);
  return text;
}

}  // namespace kalfem::command
