#include <fmt/format.h>

#include "console.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

std::string options_of(const VerbForCompletion& verb) { return fmt::format("{}", fmt::join(verb.options, " ")); }

std::string bash(const std::vector<VerbForCompletion>& verbs) {
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

std::string zsh(const std::vector<VerbForCompletion>& verbs) {
  return "autoload -U +X bashcompinit && bashcompinit\n" + bash(verbs);
}

std::string fish(const std::vector<VerbForCompletion>& verbs) {
  std::string text;
  for (const auto& verb : verbs) {
    text += fmt::format("complete -c kalfem -n __fish_use_subcommand -f -a {} -d '{}'\n", verb.name, verb.meaning);
    for (const auto& option : verb.options)
      text +=
          fmt::format("complete -c kalfem -n '__fish_seen_subcommand_from {}' -l {}\n", verb.name, option.substr(2));
  }
  return text;
}

}  // namespace

ExitCode completion(const std::string& shell, const std::vector<VerbForCompletion>& verbs) {
  print_text(shell == "fish" ? fish(verbs) : shell == "zsh" ? zsh(verbs) : bash(verbs));
  return done;
}

}  // namespace kalfem::command
