// SPDX-License-Identifier: Apache-2.0
#include "command_line.hpp"

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <map>
#include <new>
#include <sstream>
#include <string_view>

#include "build_stamp.hpp"
#include "console.hpp"
#include "help.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/freed_memory.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/estimation/kernels/kernel_set.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/steps/table.hpp"
#include "little_memory.hpp"
#include "ranks.hpp"
#include "verbs.hpp"

using namespace kalfem;

namespace {

struct Arguments {
  command::RunArguments run;
  command::PlotArguments plot;
  command::SweepArguments sweep;
  command::DeckModesArguments deck;
  command::WatchArguments watch;
  command::PlayArguments play;
  command::ModalArguments modal;
  command::MatchArguments match;
  std::string case_file, resumed, page, shell, topic, kind, folder;
  std::vector<std::string> units, files;
  RunsAre runs_are = RunsAre::answers;
  bool json = false, quiet = false, laws = false, ledger = false, large = false;
};

void add_changes(CLI::App& verb, Arguments& arguments) {
  verb.add_option("--set", arguments.run.changes,
                  "KEY=VALUE, in place of the value of the case: --set simulate.duration=4s; several times")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

CLI::Option* add_units(CLI::App& verb, Arguments& arguments) {
  verb.add_option(
          "--subcase", arguments.deck.subcase,
          "SUBCASE of a Nastran deck whose structure is meant; default: the first one with METHOD, or the first")
      ->type_name("N");
  return verb
      .add_option("--units", arguments.units, "units of a deck: length, mass and time, such as mm t s; default: SI")
      ->type_name("LENGTH MASS TIME")
      ->expected(3);
}

CLI::App* add_run_verb(CLI::App& app, std::string_view verb, std::string_view meaning, Arguments& arguments) {
  auto* command = app.add_subcommand(std::string(verb), std::string(meaning));
  command->add_option("case", arguments.run.case_file, "case file (YAML)")->required();
  command->add_option("--out", arguments.run.folder, "folder for the results; default: <case>.kalfem-out")
      ->type_name("FOLDER");
  add_changes(*command, arguments);
  command->add_flag("--strict", arguments.run.strict, "exit with 3 where the results are suspicious, too");
  auto* verbose = command->add_flag("--verbose", arguments.run.verbose,
                                    "tell also which filters were tried and where the time went");
  auto* quiet = command->add_flag("--quiet", arguments.quiet, "print the verdict only, beside warnings and errors");
  command->add_flag("--json", arguments.json, "print summary.json in place of the report")
      ->excludes(quiet)
      ->excludes(verbose);
  quiet->excludes(verbose);
  return command;
}

/// What an option takes: "N", without the check behind it, "N:INT in [1 - 9]".
std::string value_of(const CLI::Option& option) {
  return option.get_type_size() == 0 ? "" : option.get_type_name().substr(0, option.get_type_name().find(':'));
}

command::VerbUsage usage_of(const CLI::App& verb) {
  command::VerbUsage usage{verb.get_name(), verb.get_description(), {}, {}};
  for (const auto* option : verb.get_options()) {
    const std::string value = value_of(*option), meaning = option->get_description();
    if (option->get_positional())
      usage.arguments.push_back({option->get_name(true), value, meaning, option->get_required()});
    for (const auto& name : option->get_lnames()) usage.options.push_back({"--" + name, value, meaning});
  }
  return usage;
}

std::vector<command::VerbUsage> verbs_of(const CLI::App& app) {
  std::vector<command::VerbUsage> verbs;
  for (const auto* verb : app.get_subcommands(nullptr)) verbs.push_back(usage_of(*verb));
  return verbs;
}

/// modes.json, a MATLAB file, or a universal file of any ending.
bool holds_modes(const std::filesystem::path& file) {
  const auto ending = file.extension();
  return ending != ".yaml" && ending != ".yml" && std::filesystem::is_regular_file(file);
}

command::ExitCode modes_of_deck(Arguments& arguments) {
  if (!arguments.run.changes.empty())
    throw InvalidInput("--set: a deck has no keys to change", "only a case has", "write a case that names the deck");
  auto& deck = arguments.deck;
  deck.file = arguments.run.case_file;
  deck.units = arguments.units;
  deck.folder = arguments.run.folder;
  deck.as_json = arguments.json;
  return command::modes_of_deck(deck);
}

command::ExitCode check(const Arguments& arguments) {
  if (is_deck(arguments.case_file))
    return command::check_deck(
        {arguments.case_file, arguments.units, arguments.page, arguments.ledger, arguments.deck.subcase});
  if (arguments.ledger)
    throw InvalidInput("--ledger: a case has no ledger", "it lists the fields of a deck", "name the deck itself");
  return command::check(arguments.case_file, arguments.run.changes, arguments.page);
}

command::ExitCode execute(const CLI::App& app, Arguments& arguments) {
  if (app.got_subcommand("check")) return check(arguments);
  if (app.got_subcommand("inspect"))
    return command::inspect({arguments.files, arguments.json, arguments.large, arguments.page});
  if (app.got_subcommand("modal")) {
    arguments.modal.as_json = arguments.json;
    return command::modal(arguments.modal);
  }
  if (app.got_subcommand("match")) {
    arguments.match.as_json = arguments.json;
    return command::match(arguments.match);
  }
  if (app.got_subcommand("new")) return command::new_case(arguments.kind, arguments.folder);
  if (app.got_subcommand("completion")) return command::completion(arguments.shell, verbs_of(app));
  if (app.got_subcommand("schema")) return command::schema(arguments.json, arguments.laws, arguments.topic);
  if (app.got_subcommand("report")) return command::report(arguments.folder, arguments.json);
  if (app.got_subcommand("compare"))
    return command::compare(arguments.files, arguments.runs_are, arguments.json, arguments.page);
  if (app.got_subcommand("plot")) return command::plot(arguments.plot);
  if (app.got_subcommand("watch")) {
    arguments.watch.changes = arguments.run.changes;
    return command::watch(arguments.watch);
  }
  if (app.got_subcommand("play")) {
    arguments.play.changes = arguments.run.changes;
    return command::play(arguments.play);
  }
  if (app.got_subcommand("sweep")) {
    arguments.sweep.changes = arguments.run.changes;
    return command::sweep(arguments.sweep);
  }
  if (app.got_subcommand("correlate") && holds_modes(arguments.run.case_file))
    return command::correlate_file(arguments.run.case_file, arguments.json);
  if (app.got_subcommand("modes") && is_deck(arguments.run.case_file)) return modes_of_deck(arguments);
  if (arguments.json) arguments.run.told = command::Told::json;
  if (arguments.quiet) arguments.run.told = command::Told::verdict;
  if (!arguments.resumed.empty()) return command::resume(arguments.resumed, arguments.run);
  if (arguments.run.case_file.empty())
    throw InvalidInput("no case is given", "", "name a case file, or an interrupted run: kalfem run --resume DIR");
  for (const auto* step : verbs())
    if (app.got_subcommand(std::string(step->name))) return command::run(arguments.run, step->name);
  return command::run(arguments.run, every_step);
}

/// Runs a part of the command; what it throws becomes a message and an exit code.
template <class Part>
int guarded(const Part& part) {
  try {
    const StopScope scope(&command::stop_question());
    return part();
  } catch (const Interrupted&) {
    command::print_error_text("stopped before anything was finished\n");
    return command::interrupted;
  } catch (const WriteFailure& error) {
    command::print_error("{}\n", error.what());
    return command::cannot_write;
  } catch (const InvalidInput& error) {
    command::print_error("{}\n", error.what());
    return command::mend_the_input;
  } catch (const std::bad_alloc&) {
    command::print_error_text(command::no_memory);
    return command::mend_the_input;
  } catch (const std::exception& error) {
    command::print_error("kalfem: internal error: {}\n", error.what());
    return command::a_bug;
  }
}

/// What is wrong with the arguments, and where to read how they should be.
std::string mistake_of(const CLI::App& app, const CLI::ParseError& error) {
  const auto parsed = app.get_subcommands();
  const std::string place = parsed.empty() ? "kalfem" : "kalfem " + parsed.front()->get_name();
  std::vector<std::string> names;
  for (const auto& usage : verbs_of(app))
    if (parsed.empty())
      names.push_back(usage.name);
    else if (usage.name == parsed.front()->get_name())
      for (const auto& option : usage.options) names.push_back(option.name);
  const auto kind = static_cast<CLI::ExitCodes>(error.get_exit_code());
  std::string text = error.what();
  const auto left = app.remaining(true);
  if (!left.empty() && (parsed.empty() || kind == CLI::ExitCodes::ExtrasError)) {
    const auto& word = left.front();
    text = (word.starts_with('-') ? "there is no option '" + word + "'"
            : parsed.empty()      ? "there is no verb '" + word + "'"
                                  : "'" + word + "' is one argument too many") +
           did_you_mean(word, names);
  } else if (kind == CLI::ExitCodes::RequiredError) {
    text = "no verb is given";
    for (const auto* verb : parsed)
      for (const auto* option :
           verb->get_options([](const CLI::Option* each) { return each->get_required() && each->count() == 0; }))
        text = "'" + option->get_name() + "' is missing";
  }
  return fmt::format("{}: {}; {} --help {}\n", place, text, place,
                     parsed.empty() ? "lists the verbs" : "says how it is used");
}

/// Help, the version, or what is wrong with the arguments.
command::ExitCode told(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream output, errors;
  const bool asked_for = app.exit(error, output, errors) == 0;
  command::print_text(output.str());
  if (!asked_for) command::print_error_text(mistake_of(app, error));
  command::require_output();
  return asked_for ? command::done : command::mend_the_input;
}

void add_sweep(CLI::App& app, Arguments& arguments) {
  auto* sweep =
      app.add_subcommand("sweep", "run a case many times on all cores: combinations of values, seeds of noise");
  sweep->add_option("case", arguments.sweep.case_file, "case file (YAML)")->required();
  sweep
      ->add_option("--grid", arguments.sweep.grid,
                   "KEY=VALUE,VALUE,...: a key with the values that it takes; several times: every combination")
      ->type_name("KEY=VALUE,...")
      ->allow_extra_args(false);
  sweep->add_option("--seeds", arguments.sweep.seeds, "realisations of the noise of a simulated record, seeds 1 to N")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000));
  sweep->add_option("--threads", arguments.sweep.threads, "runs at a time; default: one a processor core")
      ->type_name("N")
      ->check(CLI::Range(1, 4096));
  sweep->add_option("--out", arguments.sweep.folder, "folder for the results; default: <case>.kalfem-sweep")
      ->type_name("FOLDER");
  add_changes(*sweep, arguments);
}

void add_live_verbs(CLI::App& app, Arguments& arguments) {
  auto& watched = arguments.watch;
  auto* watch = app.add_subcommand("watch", "estimate from samples as they come, for as long as they come");
  watch->add_option("case", watched.case_file, "case file (YAML) with `live`, or a folder of them")->required();
  auto* log =
      watch
          ->add_option("--log", watched.log,
                       "keep every line that comes in at the end of this file; of a folder of cases: in this folder")
          ->type_name("FILE");
  auto* port = watch->add_option("--port", watched.port, "read lines at this TCP port of 127.0.0.1, not standard input")
                   ->type_name("N")
                   ->check(CLI::Range(1, 65535));
  watch
      ->add_option("--replay", watched.replay,
                   "read such a file from its beginning, with the same estimates; no state is read or written")
      ->type_name("FILE")
      ->excludes(log)
      ->excludes(port);
  watch
      ->add_option("--metrics", watched.metrics,
                   "tell metrics (/metrics, for Prometheus) and health (/health) at this TCP port of 127.0.0.1")
      ->type_name("N")
      ->check(CLI::Range(1, 65535));
  watch
      ->add_option("--page", watched.page,
                   "show estimates, verdict, alarms and trend as they come, on a page at this TCP port of 127.0.0.1")
      ->type_name("N")
      ->check(CLI::Range(1, 65535));
  watch
      ->add_option("--state", watched.state,
                   "keep the state, alarms and trend in this folder; of a folder of cases: in a folder for each in it")
      ->type_name("FOLDER");
  watch->add_option("--format", watched.format, "of the lines: json, or influx, the line protocol of InfluxDB")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"json", "influx"}));
  watch->add_option("--output", watched.output, "write the lines to the end of this file, not to standard output")
      ->type_name("FILE");
  add_changes(*watch, arguments);
  auto& played = arguments.play;
  auto* play = app.add_subcommand("play", "publish the record of a case, or its simulation, for `watch`");
  play->add_option("case", played.case_file, "case file (YAML) with `record` or `simulate`")->required();
  play->add_option("--speed", played.speed, "so many times as fast as it was recorded; 0: as fast as it goes")
      ->type_name("X")
      ->check(CLI::Range(0.0, 1e9));
  play->add_option("--start", played.start, "time of the first sample in seconds; default: that of the record")
      ->type_name("T");
  play->add_option("--block", played.block, "samples in a line; default: 10")
      ->type_name("N")
      ->check(CLI::Range(1, 10000));
  play->add_option(
          "--fault", played.faults,
          "KIND:CHANNEL:FROM[:TO[:VALUE]], a sensor that is dead, has a spike or an offset, or a gap, in seconds "
          "from the first sample; several times")
      ->type_name("FAULT")
      ->allow_extra_args(false);
  play->add_option("--mqtt", played.mqtt, "publish the lines to this topic of a broker of MQTT, not to standard output")
      ->type_name("BROKER[:PORT]/TOPIC");
  add_changes(*play, arguments);
}

void add_modal(CLI::App& app, Arguments& arguments) {
  auto& asked = arguments.modal;
  auto& options = asked.options;
  auto* modal = app.add_subcommand(
      "modal", "identify modes from responses alone or to measured forces, with their standard deviations");
  modal
      ->add_option(
          "records", asked.files,
          "measured file, file of frequency responses, or case file (YAML) with `record`; several: set-ups whose "
          "sensors were moved, merged by those that stay")
      ->required();
  modal->add_option("--channel", options.channels, "identify from this channel; several times; default: all but forces")
      ->type_name("NAME")
      ->allow_extra_args(false);
  modal
      ->add_option("--reference", options.references,
                   "correlate all channels with this one, which stays in all set-ups; several times; default: with all")
      ->type_name("NAME")
      ->allow_extra_args(false);
  modal
      ->add_option("--input", options.inputs,
                   "this channel is a force: identify from frequency responses to it; several times")
      ->type_name("NAME")
      ->allow_extra_args(false);
  modal
      ->add_option("--segment", options.forced.segment,
                   "with --input: length of the averaged segments, in s; default: such that sixteen cover the record")
      ->type_name("S");
  modal
      ->add_option("--estimator", options.forced.estimator,
                   "with --input: h1 (noise on the responses), h2 (on the force), hv (on both); default: h1")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, FrfEstimator>{
              {"h1", FrfEstimator::h1}, {"h2", FrfEstimator::h2}, {"hv", FrfEstimator::hv}},
          CLI::ignore_case))
      ->type_name("NAME");
  modal
      ->add_option("--window", options.forced.window,
                   "with --input: hann, or rectangular where responses decay within a segment; default: hann")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, SpectralWindow>{{"hann", SpectralWindow::hann},
                                                                        {"rectangular", SpectralWindow::rectangular}},
                                  CLI::ignore_case))
      ->type_name("NAME");
  modal->add_option("--band", asked.band, "look for modes between two frequencies, in Hz: filters and resamples")
      ->type_name("FROM TO")
      ->expected(2);
  modal
      ->add_option("--subspace", options.subspace,
                   "singular vectors of the correlations (covariance) or of the future's projection onto the past "
                   "(data); default: covariance")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, SubspaceMethod>{{"covariance", SubspaceMethod::covariance},
                                                                        {"data", SubspaceMethod::data}},
                                  CLI::ignore_case))
      ->type_name("NAME");
  modal
      ->add_option("--max-order", options.max_order,
                   "largest order of the models; default: four a channel, 30 to 100; of frequency responses 120")
      ->type_name("N");
  modal
      ->add_option("--pole", asked.poles,
                   "take this pole of the stabilisation diagram for a mode, by its frequency and order; several times, "
                   "in place of those that hold over the orders")
      ->type_name("HZ[:ORDER]")
      ->allow_extra_args(false);
  modal->add_option("--block-rows", options.block_rows, "of the Hankel matrix; default: a period of the lowest mode")
      ->type_name("N");
  modal->add_option("--blocks", options.blocks, "parts of the record that the deviations come from; default: 100")
      ->type_name("N");
  modal->add_flag("--track", asked.track, "the records are of one structure at several times: follow its modes");
  modal
      ->add_option("--covariates", asked.covariates,
                   "with --track: table of temperatures and the like, one row a record, which frequencies follow")
      ->type_name("FILE");
  modal->add_option("--sample-rate", asked.sample_rate, "in Hz, where the file does not state it")->type_name("HZ");
  modal->add_option("--out", asked.folder, "write tables, JSON and a universal file into this folder")
      ->type_name("FOLDER");
  modal->add_option("--page", asked.page, "write an HTML page with the stabilisation diagram to this file")
      ->type_name("FILE");
  modal->add_flag("--json", arguments.json, "print modes, shapes and the stabilisation diagram as JSON");
}

void add_match(CLI::App& app, Arguments& arguments) {
  auto& asked = arguments.match;
  auto* match = app.add_subcommand("match", "find the nodes of a deck at which the sensors of a test sit");
  match->add_option("points", asked.points, "geometry of the test: universal file, or table of name, x, y, z")
      ->required();
  match->add_option("model", asked.model, "deck (.inp, .bdf, .dat, .nas)")->required();
  match->add_option("--units", asked.units, "units of the deck: length, mass and time, such as mm t s; default: SI")
      ->type_name("LENGTH MASS TIME")
      ->expected(3);
  match
      ->add_option("--length", asked.length,
                   "unit of the test's coordinates, where its file does not state it; default: m")
      ->type_name("UNIT");
  match->add_flag("--scale", asked.scale, "fit a factor of the test's lengths too, within 10 %");
  match->add_option("--noise", asked.noise, "standard deviation of a measured coordinate, in mm; default: from the fit")
      ->type_name("MM")
      ->check(CLI::Range(1e-6, 1e6));
  match->add_option("--page", asked.page, "write an HTML page with the table and a picture to this file")
      ->type_name("FILE");
  match->add_flag("--json", arguments.json, "print the fit and the nodes as JSON");
}

void add_verbs(CLI::App& app, Arguments& arguments) {
  app.formatter_fn([](const CLI::App* at, const std::string&, CLI::AppFormatMode) {
    return at->get_parent() ? command::help_of(usage_of(*at)) : command::overview(verbs_of(*at));
  });
  app.set_help_flag("-h,--help", "say how the verb is used");
  app.set_version_flag("--version",
                       fmt::format("kalfem {} ({}; {} kernels)", version, command::build_stamp, kernels().name));
  app.require_subcommand(1);
  auto* run = add_run_verb(app, "run", "run everything the case asks for", arguments);
  run->get_option("case")->required(false);
  auto* resume = run->add_option("--resume", arguments.resumed,
                                 "go on with the interrupted run of this folder, in place of a case")
                     ->type_name("FOLDER");
  for (const char* other : {"case", "--out", "--set"}) resume->excludes(run->get_option(other));
  for (const auto* step : verbs()) {
    add_run_verb(app, step->name, step->meaning, arguments);
    if (step->name == "static") add_sweep(app, arguments);  // its place in the help
  }
  app.get_subcommand("correlate")
      ->get_option("case")
      ->description("case file (YAML) with `update`, or modes alone: modes.json, a universal or MATLAB file");
  auto* modes = app.get_subcommand("modes");
  add_units(*modes, arguments);
  modes->add_option("--modes", arguments.deck.count, "how many modes of a deck; default: 20")
      ->type_name("N")
      ->check(CLI::Range(1, 10000));
  auto* check = app.add_subcommand("check", "validate and explain a case file or a deck without running it");
  check->add_option("case", arguments.case_file, "case file (YAML) or deck (.inp, .bdf, .dat, .nas)")->required();
  add_changes(*check, arguments);
  check->add_option("--page", arguments.page, "write the model check to this HTML file, with a picture of the mesh")
      ->type_name("FILE");
  add_units(*check, arguments);
  check->add_flag("--ledger", arguments.ledger, "list every field that a deck fills: used, told or refused");
  add_live_verbs(app, arguments);
  auto* report = app.add_subcommand("report", "print again what a finished run printed");
  report->add_option("folder", arguments.folder, "folder of the results")->required();
  report->add_flag("--json", arguments.json, "print summary.json in place of the report");
  auto* compare = app.add_subcommand("compare", "compare finished runs: parameters, errors, verdicts, times");
  compare->add_option("folders", arguments.files, "folders of the results; the first is what the others differ from")
      ->required();
  compare->add_flag_callback(
      "--population", [&] { arguments.runs_are = RunsAre::members; },
      "the runs are nominally equal structures, or campaigns at one: mean, spread, and the interval of the next");
  compare->add_flag("--json", arguments.json, "as JSON");
  compare->add_option("--page", arguments.page, "write an HTML page with the courses of the parameters to this file")
      ->type_name("FILE");
  auto* plot = app.add_subcommand("plot", "draw the figures of a finished run for print");
  plot->add_option("folder", arguments.plot.folder, "folder of the results")->required();
  plot->add_option("--out", arguments.plot.output, "folder for the figures; default: figures in that of the results")
      ->type_name("FOLDER");
  plot->add_option("--format", arguments.plot.format, "svg or png; default: svg")
      ->type_name("svg|png")
      ->check(CLI::IsMember({"svg", "png"}));
  plot->add_option("--width", arguments.plot.width, "in cm: 8.5 for one column, 17 for two; default: 8.5")
      ->type_name("CM")
      ->check(CLI::Range(4.0, 60.0));
  plot->add_option("--point", arguments.plot.points, "draw the motion of this point; several times")
      ->type_name("POINT")
      ->allow_extra_args(false);
  auto* inspect = app.add_subcommand("inspect", "tell what measured files hold, and what is odd about their channels");
  inspect->add_option("files", arguments.files, "measured files")->required();
  inspect->add_flag("--json", arguments.json, "as JSON, an array of one object a file");
  inspect->add_flag("--large", arguments.large,
                    "read also parts of compressed files that unpack to far more than the file");
  inspect->add_option("--page", arguments.page, "write an HTML page with the course of every channel to this file")
      ->type_name("FILE");
  add_modal(app, arguments);
  add_match(app, arguments);
  auto* schema = app.add_subcommand("schema", "print the reference of the case file");
  schema->add_option("section", arguments.topic, "one section of the case file: estimate");
  schema->add_flag("--json", arguments.json, "as a JSON Schema, for editors");
  schema->add_flag("--laws", arguments.laws, "list the connector laws and their parameters");
  auto* new_case = app.add_subcommand("new", "write a commented case with its data, to run and to change");
  new_case->add_option("kind", arguments.kind, fmt::format("{}", fmt::join(command::starter_kinds(), ", ")))
      ->required()
      ->check(CLI::IsMember(command::starter_kinds()));
  new_case->add_option("folder", arguments.folder, "where to write it")->required();
  app.add_subcommand("completion", "print what a shell needs to complete verbs and options, or the manual page")
      ->add_option("shell", arguments.shell, "bash, zsh or fish; man")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish", "man"}));
}

int parse_and_execute(int argc, char** argv) {
  CLI::App app{"Identifies and updates nonlinear finite-element models of structures from vibration measurements.",
               "kalfem"};
  Arguments arguments;
  add_verbs(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return told(app, error);
  }
  const auto code = execute(app, arguments);
  command::require_output();
  return code;
}

}  // namespace

int command::command_line(int argc, char** argv) {
  prepare_streams();
  keep_freed_memory();
  listen_to_signals();
  return guarded([&] {
    const LittleMemory little_memory;
    return on_ranks(argc, argv, [&] { return parse_and_execute(argc, argv); });
  });
}
