// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/modal/modal_options.hpp"
#include "kalfem/model/unit_system.hpp"
#include "kalfem/report/finished/run_comparison.hpp"
#include "kalfem/steps/run_study.hpp"

namespace kalfem::command {

/// Exit codes of the contract.
/// 1 also where the machine does not take the output: the disk is full, stdout is closed.
enum ExitCode { done = 0, a_bug = 1, cannot_write = 1, mend_the_input = 2, not_usable = 3, interrupted = 130 };

enum class Told { report, verdict, json };  ///< on stdout; warnings and errors go to stderr in any case

struct RunArguments {
  std::string case_file;
  std::string folder;                ///< of the results; empty: <case>.kalfem-out beside the case
  std::vector<std::string> changes;  ///< KEY=VALUE
  Told told = Told::report;
  bool verbose = false;  ///< the report also says how the filter was chosen and where the time went
  bool strict = false;   ///< suspicious results are not usable
};

/// run (every_step), or the verb of a step (run_steps()), with the steps that it needs. A case without the section of
/// the step is an error. Asked to stop (stop_question()), it writes what is finished.
ExitCode run(const RunArguments& arguments, std::string_view verb);
/// run --resume: goes on with the interrupted run of a folder, with its verb, case and changes. Of the arguments, only
/// how it is told counts, and whether it is strict.
ExitCode resume(const std::string& folder, const RunArguments& arguments);
/// report: what a finished run printed, from its folder, with its exit code; or its summary.json.
ExitCode report(const std::string& folder, bool as_json);
/// compare: finished runs side by side, answers to one question or members of a population, as tables, JSON or a page.
ExitCode compare(const std::vector<std::string>& folders, RunsAre are, bool as_json, const std::string& page_file);

struct SweepArguments {
  std::string case_file;
  std::string folder;                ///< of the results; empty: <case>.kalfem-sweep beside the case
  std::vector<std::string> changes;  ///< KEY=VALUE, of every run
  std::vector<std::string> grid;     ///< KEY=VALUE,VALUE,...
  int seeds = 0, threads = 0;
};
/// sweep: many runs of one case in one process, their numbers in one table. What an interrupted sweep has finished is
/// not made again. Done where any run is usable.
ExitCode sweep(const SweepArguments& arguments);

struct PlotArguments {
  std::string folder;  ///< of a finished run
  std::string output;  ///< folder of the figures; empty: `figures` in that of the run
  std::string format = "svg";
  double width = 8.5;               ///< [cm]
  std::vector<std::string> points;  ///< whose motion is drawn; empty: the two first ones that move
};
/// plot: figures of a finished run for print, a file each.
ExitCode plot(const PlotArguments& arguments);

/// KEY=VALUE, or KEY= to remove a key. Throws InvalidInput with every text that is neither.
std::vector<CaseChange> changes_of(const std::vector<std::string>& texts);

/// check: validate and explain, run nothing. With a page file, the model check of the substructures goes there too.
ExitCode check(const std::string& case_file, const std::vector<std::string>& changes, const std::string& page_file);

struct CheckDeckArguments {
  std::string file;
  std::vector<std::string> units;            ///< none (SI), or length, mass and time
  std::string page_file;                     ///< empty: none
  bool ledger = false;                       ///< list what became of every field
  std::optional<std::int64_t> subcase = {};  ///< of Nastran, whose structure is meant
};
/// check of a deck alone: its contents, the cards that kalfem ignores, and the model check.
ExitCode check_deck(const CheckDeckArguments& arguments);

struct DeckModesArguments {
  std::string file;
  std::vector<std::string> units;  ///< none (SI), or length, mass and time
  std::string folder;              ///< of the shapes; empty: they are not written
  int count = 20;
  bool as_json = false;
  std::optional<std::int64_t> subcase = {};  ///< of Nastran, whose structure is meant
};
/// modes of a deck alone, at full order: a table, and the shapes for ParaView.
ExitCode modes_of_deck(const DeckModesArguments& arguments);

struct WatchArguments {
  std::string case_file;
  std::vector<std::string> changes;  ///< KEY=VALUE
  std::string log;                   ///< file that keeps what comes in; empty: none
  std::string replay;                ///< such a file, read in the place of a stream; empty: none
  int port = 0;                      ///< of TCP on the loopback; 0: as the case says, or standard input
  int metrics = 0;                   ///< port on the loopback for metrics and health; 0: as the case says, or none
  int page = 0;                      ///< port on the loopback for the page; 0: as the case says, or none
  std::string state;                 ///< folder; of a folder of cases: that of their folders; empty: as the case says
  std::string format = "json";       ///< or "influx"
  std::string output;                ///< file that lines go to the end of; empty: standard output
};
/// watch: a live case, or every one of a folder. Reads lines of samples until they end or it is asked to stop; lines of
/// estimates and alarms go to stdout. Not usable where a filter has stopped.
ExitCode watch(const WatchArguments& arguments);

struct PlayArguments {
  std::string case_file;
  std::vector<std::string> changes, faults;
  std::string mqtt;                  ///< BROKER[:PORT]/TOPIC that lines are published to; empty: standard output
  double speed = 1.0;                ///< of the clock; 0: as fast as it goes
  int block = 10;                    ///< samples a line
  std::optional<double> start = {};  ///< time of the first sample [s]; empty: that of the record
};
/// play: publishes the record of a case, or its simulation, as lines that `watch` reads.
ExitCode play(const PlayArguments& arguments);

struct InspectArguments {
  std::vector<std::string> files;
  bool as_json = false;
  bool large = false;  ///< also parts of compressed files that unpack to far more than the file
  std::string page;    ///< HTML file to write; empty: none
};

/// inspect: what measured files hold and what is odd about their channels, as text, JSON (one array) or a page.
ExitCode inspect(const InspectArguments& arguments);
struct ModalArguments {
  std::vector<std::string> files;  ///< a record, or a case with one; several: set-ups with common references
  ModalOptions options;
  std::optional<double> sample_rate = {};  ///< [Hz], where the file does not state it
  std::vector<double> band = {};           ///< [Hz]: none, or two
  std::vector<std::string> poles = {};     ///< HZ or HZ:ORDER
  std::string folder;                      ///< of the results; empty: they are not written
  std::string page;                        ///< HTML file to write; empty: none
  bool as_json = false;
  bool track = false;      ///< several records are of one structure at several times
  std::string covariates;  ///< with `track`: table of numbers that frequencies follow, one row a record; empty: none
};
/// modal: the modes of a record alone, of its responses to forces, or of a file of frequency responses, with their
/// standard deviations. Not usable where there is none.
ExitCode modal(const ModalArguments& arguments);
struct MatchArguments {
  std::string points, model;         ///< the test's geometry, and the deck
  std::vector<std::string> units;    ///< of the deck: none (SI), or length, mass and time
  std::string length = "m";          ///< unit of the test's coordinates
  bool scale = false;                ///< fit a factor of the test's lengths
  std::optional<double> noise = {};  ///< standard deviation of a coordinate, in mm
  std::string page;                  ///< HTML file to write; empty: none
  bool as_json = false;
};
/// match: which node of a deck each point of a test's geometry is. Not usable where a point is not sure.
ExitCode match(const MatchArguments& arguments);
/// "mm t s": one unit of each.
UnitSystem unit_system(const std::vector<std::string>& words);
/// A case for correlate: load_study() of a case with measured shapes that do not agree with any mode of the model
/// throws, because they cannot be updated on; correlate is there to tell why they do not.
Study load_for_correlation(const std::string& case_file, const std::vector<std::string>& changes,
                           const Progress& progress);
/// correlate of a file of modes alone: how well its sensors tell the modes apart.
ExitCode correlate_file(const std::string& file, bool as_json);
/// schema: the case-file reference as text, all or one section; or as JSON Schema; or the connector laws.
ExitCode schema(bool as_json, bool laws, const std::string& topic);
/// The JSON Schema, for editors.
std::string case_file_schema();
/// new: a commented case with its data in `folder`, where none of its files may be, and the schema for editors.
ExitCode new_case(const std::string& kind, const std::filesystem::path& folder);
std::vector<std::string> starter_kinds();

/// An option or an argument, as the help of a verb states it.
struct OptionUsage {
  std::string name;   ///< "--out"; of an argument, "case"
  std::string value;  ///< what it takes, "TEXT"; empty for a flag
  std::string meaning;
  bool required = false;
};
/// A verb as its help states it.
struct VerbUsage {
  std::string name, meaning;
  std::vector<OptionUsage> arguments, options;
};

/// completion: the script that bash, zsh or fish reads, or the manual page.
ExitCode completion(const std::string& kind, const std::vector<VerbUsage>& verbs);
/// The manual page, in the language of man(7).
std::string manual_page(const std::vector<VerbUsage>& verbs);

}  // namespace kalfem::command
