// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "console.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

std::string options_of(const VerbUsage& verb) {
  std::string names;
  for (const auto& option : verb.options) names += (names.empty() ? "" : " ") + option.name;
  return names;
}

std::string bash(const std::vector<VerbUsage>& verbs) {
  std::string names, cases;
  for (const auto& verb : verbs) {
    names += (names.empty() ? "" : " ") + verb.name;
    cases += fmt::format("      {}) words=\"{}\" ;;\n", verb.name, options_of(verb));
  }
  return fmt::format(R"(_kalfem() {{
  local word="${{COMP_WORDS[COMP_CWORD]}}" words=""
  if [ "$COMP_CWORD" -eq 1 ]; then
    words="{}"
  elif [[ "$word" == -* ]]; then
    case "${{COMP_WORDS[1]}}" in
{}    esac
  else
    COMPREPLY=($(compgen -f -- "$word"))
    return
  fi
  COMPREPLY=($(compgen -W "$words" -- "$word"))
}}
complete -o filenames -F _kalfem kalfem
)",
                     names, cases);
}

std::string zsh(const std::vector<VerbUsage>& verbs) {
  return "autoload -U +X bashcompinit && bashcompinit\n" + bash(verbs);
}

/// Text that may stand between single quotes.
std::string without_quotes(std::string text) {
  std::erase(text, '\'');
  return text;
}

std::string fish(const std::vector<VerbUsage>& verbs) {
  std::string text;
  for (const auto& verb : verbs) {
    text += fmt::format("complete -c kalfem -n __fish_use_subcommand -f -a {} -d '{}'\n", verb.name,
                        without_quotes(verb.meaning));
    for (const auto& option : verb.options)
      text += fmt::format("complete -c kalfem -n '__fish_seen_subcommand_from {}' -l {} -d '{}'\n", verb.name,
                          option.name.substr(2), without_quotes(option.meaning));
  }
  return text;
}

}  // namespace

ExitCode completion(const std::string& kind, const std::vector<VerbUsage>& verbs) {
  if (kind == "man")
    print_text(manual_page(verbs));
  else
    print_text(kind == "fish" ? fish(verbs) : kind == "zsh" ? zsh(verbs) : bash(verbs));
  return done;
}

}  // namespace kalfem::command
