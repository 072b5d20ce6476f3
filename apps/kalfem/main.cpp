#include <CLI/CLI.hpp>
#include <exception>
#include <sstream>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/formats/deck.hpp"
#include "verbs.hpp"

using namespace kalfem;

namespace {

struct Arguments {
  std::string case_file, folder, page;
  std::vector<std::string> units, files;
  bool json = false, laws = false, strict = false;
};

CLI::App* add_run_verb(CLI::App& app, const char* verb, const char* meaning, Arguments& arguments) {
  auto* command = app.add_subcommand(verb, meaning);
  command->add_option("case", arguments.case_file, "case file (YAML)")->required();
  command->add_option("--out", arguments.folder, "folder for the results; default: <case>.kalfem-out");
  command->add_flag("--strict", arguments.strict, "exit with 3 where the results are suspicious, too");
  return command;
}

command::ExitCode execute(const CLI::App& app, const Arguments& arguments) {
  if (app.got_subcommand("check"))
    return is_deck(arguments.case_file) ? command::check_deck(arguments.case_file, arguments.units, arguments.page)
                                        : command::check(arguments.case_file, arguments.page);
  if (app.got_subcommand("inspect")) return command::inspect(arguments.files, arguments.json, arguments.page);
  if (app.got_subcommand("schema")) return command::schema(arguments.json, arguments.laws);
  for (const auto& [verb, step] : {std::pair{"modes", Step::modes},
                                   {"simulate", Step::simulate},
                                   {"estimate", Step::estimate},
                                   {"predict", Step::predict},
                                   {"update", Step::update},
                                   {"infer", Step::infer},
                                   {"place", Step::place}})
    if (app.got_subcommand(verb)) return command::run(arguments.case_file, step, arguments.folder, arguments.strict);
  return command::run(arguments.case_file, Step::everything, arguments.folder, arguments.strict);
}

/// Runs a part of the command; what it throws becomes a message and an exit code.
template <class Part>
int guarded(const Part& part) {
  try {
    return part();
  } catch (const WriteFailure& error) {
    command::print_error("{}\n", error.what());
    return command::cannot_write;
  } catch (const InvalidInput& error) {
    command::print_error("{}\n", error.what());
    return command::mend_the_input;
  } catch (const std::exception& error) {
    command::print_error("kalfem: internal error: {}\n", error.what());
    return command::a_bug;
  }
}

/// Help, the version, or what is wrong with the arguments.
int told(const CLI::App& app, const CLI::ParseError& error) {
  return guarded([&] {
    std::ostringstream output, errors;
    const bool asked_for = app.exit(error, output, errors) == 0;
    command::print_text(output.str());
    command::print_error_text(errors.str());
    command::require_output();
    return asked_for ? command::done : command::mend_the_input;
  });
}

}  // namespace

int main(int argc, char** argv) {
  command::prepare_streams();
  CLI::App app{"Identifies and updates nonlinear finite-element models of structures from vibration measurements.",
               "kalfem"};
  app.set_version_flag("--version", version);
  app.require_subcommand(1);
  Arguments arguments;
  add_run_verb(app, "run", "run everything the case asks for", arguments);
  add_run_verb(app, "modes", "compute the natural modes of every substructure, full and reduced", arguments);
  add_run_verb(app, "simulate", "simulate the structure and make its record", arguments);
  add_run_verb(app, "estimate", "estimate the states and the unknown parameters, running the steps this needs",
               arguments);
  add_run_verb(app, "predict", "predict the response of a linear substructure, running the steps this needs",
               arguments);
  add_run_verb(app, "update", "update the linear substructures from measurements, running the steps this needs",
               arguments);
  add_run_verb(app, "infer", "what the data tell of the unknowns: posterior, evidence, which law", arguments);
  add_run_verb(app, "place", "where to put sensors", arguments);
  auto* check = app.add_subcommand("check", "validate and explain a case file or a deck without running it");
  check->add_option("case", arguments.case_file, "case file (YAML) or deck (.inp, .bdf, .dat, .nas)")->required();
  check->add_option("--page", arguments.page, "write the model check to this HTML file, with a picture of the mesh");
  check->add_option("--units", arguments.units, "units of a deck: length, mass and time, such as mm t s; default: SI")
      ->expected(3);
  auto* inspect = app.add_subcommand("inspect", "tell what measured files hold, and what is odd about their channels");
  inspect->add_option("files", arguments.files, "measured files")->required();
  inspect->add_flag("--json", arguments.json, "as JSON, an array of one object a file");
  inspect->add_option("--page", arguments.page, "write an HTML page with the course of every channel to this file");
  auto* schema = app.add_subcommand("schema", "print the reference of the case file");
  schema->add_flag("--json", arguments.json, "as a JSON Schema, for editors");
  schema->add_flag("--laws", arguments.laws, "list the connector laws and their parameters");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return told(app, error);
  }
  return guarded([&] {
    const auto code = execute(app, arguments);
    command::require_output();
    return code;
  });
}
