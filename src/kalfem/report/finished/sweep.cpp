// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/finished/sweep.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "kalfem/base/hash.hpp"
#include "kalfem/base/parallel.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/report/data_files.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/simulation/checkpoint.hpp"
#include "kalfem/steps/simulation/compute.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;

void check(const SweepPlan& plan) {
  IssueList issues;
  for (auto axis = plan.axes.begin(); axis != plan.axes.end(); ++axis) {
    if (axis->values.empty()) issues.add({}, "the sweep gives '" + axis->key + "' no values", "", "name at least one");
    const auto same = [&](const auto& other) { return other.key == axis->key; };
    if (std::find_if(plan.axes.begin(), axis, same) != axis || std::ranges::any_of(plan.changes, same))
      issues.add({}, "the sweep gives '" + axis->key + "' twice", "", "name each key once");
  }
  if (plan.seeds < 0) issues.add({}, "the sweep has " + std::to_string(plan.seeds) + " seeds", "", "give 1 or more");
  issues.raise();
}

/// The simulated reference; where there is none, why.
struct Reference {
  SimulationOutcome outcome;
  std::string failure;
};

/// References, each made by the first combination that asks for it: combinations that differ in `estimate` share one.
class References {
public:
  std::shared_ptr<const Reference> of(const Study& study) {
    const auto entry = entry_of(simulation_fingerprint(study));
    const std::scoped_lock lock(entry->guard);
    if (!entry->reference) {
      auto reference = std::make_shared<Reference>();
      reference->outcome = run_simulation(study, {}, reference->failure);
      reference->outcome.fields.clear();  // a sweep shows no pictures
      entry->reference = std::move(reference);
    }
    return entry->reference;
  }

private:
  struct Entry {
    std::string fingerprint;
    std::mutex guard;
    std::shared_ptr<const Reference> reference;
  };

  std::shared_ptr<Entry> entry_of(const std::string& fingerprint) {
    constexpr std::size_t most = 8;
    const std::scoped_lock lock(guard_);
    const auto known = std::ranges::find(kept_, fingerprint, [](const auto& entry) { return entry->fingerprint; });
    if (known != kept_.end()) return *known;
    if (kept_.size() == most) kept_.erase(kept_.begin());
    kept_.push_back(std::make_shared<Entry>());
    kept_.back()->fingerprint = fingerprint;
    return kept_.back();
  }

  std::mutex guard_;
  std::vector<std::shared_ptr<Entry>> kept_;  ///< the oldest first
};

/// The case with the values of one combination, for all seeds.
struct Combination {
  Study study;
  std::shared_ptr<const Reference> reference = {};  ///< empty: the case measures its record
};

/// The reference with the noise of a seed; without a seed with that of the case.
SimulationOutcome simulation_of(const Combination& combination, std::optional<int> seed) {
  SimulationOutcome simulation = combination.reference->outcome;
  if (seed) add_noise(combination.study, static_cast<std::uint64_t>(*seed), simulation);
  return simulation;
}

/// What does not depend on the machine, in one line.
std::string lasting_text(Json summary) {
  drop_times(summary);
  summary["files"] = Json::array();
  return summary.dump(-1, ' ', true, Json::error_handler_t::replace);
}

std::string summary_of(const Combination& combination, std::optional<int> seed) {
  Study study = combination.study;
  StudyResults results;
  RunOptions options;
  if (combination.reference) {
    results.failure = combination.reference->failure;
    options.simulation = [&] { return simulation_of(combination, seed); };
  }
  if (results.complete()) results = run_study(study, every_step, options);
  return lasting_text(summarise(study, results));
}

std::size_t seeds_of(const SweepPlan& plan) { return static_cast<std::size_t>(std::max(1, plan.seeds)); }

/// A run that is not made yet.
SweepRun planned_run(const SweepPlan& plan, std::size_t number) {
  SweepRun run{
      .number = number, .values = plan.values(number / seeds_of(plan)), .seed = {}, .summary = {}, .refused = {}};
  if (plan.seeds > 0) run.seed = static_cast<int>(number % seeds_of(plan)) + 1;
  return run;
}

std::string identity_of(const SweepPlan& plan, const Study& first) {
  Hash hash;
  hash.add(version);
  hash.add(first.resolved_case);
  for (const auto& file : data_files(first)) hash.add(file.sha256);
  for (const auto& [key, value] : plan.changes) hash.add(key + "=" + value.value_or("") + "\n");
  for (const auto& axis : plan.axes) hash.add(fmt::format("{}={}\n", axis.key, fmt::join(axis.values, "\n")));
  hash.add(std::to_string(plan.seeds));
  return fmt::format("{:016x}", hash.value());
}

}  // namespace

std::size_t SweepPlan::combinations() const {
  std::size_t count = 1;
  for (const auto& axis : axes) count *= axis.values.size();
  return count;
}

std::size_t SweepPlan::size() const { return combinations() * seeds_of(*this); }

std::vector<std::string> SweepPlan::values(std::size_t combination) const {
  std::vector<std::string> values(axes.size());
  for (std::size_t i = axes.size(); i-- > 0; combination /= axes[i].values.size())
    values[i] = axes[i].values[combination % axes[i].values.size()];
  return values;
}

namespace {

constexpr std::string_view check_key = ",\"check\":\"";

std::string check_of(std::string_view start) {
  Hash hash;
  hash.add(start);
  return fmt::format("{}{:016x}\"}}", check_key, hash.value());
}

/// Whether a line ends in the hash of its start.
bool is_whole(std::string_view line) {
  const std::size_t end = line.rfind(check_key);
  return end != std::string_view::npos && line.substr(end) == check_of(line.substr(0, end));
}

}  // namespace

std::string to_line(const SweepRun& run) {
  const auto text = [](const Json& json) { return json.dump(-1, ' ', true, Json::error_handler_t::replace); };
  Json start{{"run", run.number}, {"values", run.values}, {"seed", nullptr}};
  if (run.seed) start["seed"] = *run.seed;
  if (run.summary.empty()) start["refused"] = run.refused;
  std::string line = text(start);
  line.pop_back();  // the brace
  if (!run.summary.empty()) line += ",\"summary\":" + run.summary;
  return line + check_of(line);
}

std::optional<SweepRun> sweep_run_of(const std::string& line) try {
  if (!is_whole(line)) return std::nullopt;
  const Json json = Json::parse(line);
  SweepRun run{json.at("run"), json.at("values"), std::nullopt, {}, json.value("refused", std::string())};
  if (!json.at("seed").is_null()) run.seed = json.at("seed").get<int>();
  if (json.contains("summary")) run.summary = json.at("summary").dump(-1, ' ', true, Json::error_handler_t::replace);
  return run;
} catch (const Json::exception&) {
  return std::nullopt;
}

/// Combinations, each made by the first run that asks for it. Those that were asked for last are kept: runs come nearly
/// in the order of their numbers, in which seeds change fastest.
class CaseSweep::Combinations {
public:
  explicit Combinations(SweepPlan plan) : plan_(std::move(plan)), places_(plan_.combinations()) {
    const auto first = std::make_shared<Combination>(Combination{read(0)});
    identity_ = identity_of(plan_, first->study);
    places_.front().made = first;
    keep(first);
  }

  [[nodiscard]] const SweepPlan& plan() const { return plan_; }
  [[nodiscard]] const std::string& identity() const { return identity_; }

  /// The combination of a run, simulated. Throws InvalidInput, for each of its runs, where the case cannot be read.
  std::shared_ptr<const Combination> of(std::size_t run) {
    const std::size_t number = run / seeds_of(plan_);
    Place& place = places_[number];
    const std::scoped_lock lock(place.guard);
    if (place.refused) throw InvalidInput(*place.refused);
    auto made = place.made.lock();
    try {
      if (!made) made = std::make_shared<Combination>(Combination{read(number)});
      if (made->study.simulation && !made->reference) made->reference = references_.of(made->study);
    } catch (const InvalidInput& error) {
      place.refused = error;
      throw;
    }
    place.made = made;
    keep(made);
    return made;
  }

private:
  struct Place {
    std::mutex guard;
    std::weak_ptr<Combination> made;  ///< changed under the guard, before it is handed out
    std::optional<InvalidInput> refused;
  };

  void keep(const std::shared_ptr<Combination>& made) {
    const std::size_t most = plan_.seeds > 1 ? 2 : 1;
    const std::scoped_lock lock(keeping_);
    std::erase(kept_, made);
    kept_.push_back(made);
    if (kept_.size() > most) kept_.erase(kept_.begin());
  }

  /// One at a time: the readers of files do not work side by side.
  Study read(std::size_t number) {
    std::vector<CaseChange> changes = plan_.changes;
    const auto values = plan_.values(number);
    for (std::size_t i = 0; i < values.size(); ++i) changes.push_back({plan_.axes[i].key, values[i]});
    const std::scoped_lock lock(reading_);
    Study study = load_study(plan_.case_file.string(), changes);
    if (plan_.seeds > 0 && !study.simulation)
      throw InvalidInput("the sweep draws " + std::to_string(plan_.seeds) + " realisations of the noise",
                         "the case does not simulate its record", "leave the seeds out, or add `simulate`");
    return study;
  }

  SweepPlan plan_;
  std::string identity_;
  References references_;
  std::vector<Place> places_;
  std::vector<std::shared_ptr<Combination>> kept_;  ///< the one that was asked for last stands last
  std::mutex keeping_, reading_;
};

CaseSweep::CaseSweep(SweepPlan plan) {
  check(plan);
  combinations_ = std::make_unique<Combinations>(std::move(plan));
}

CaseSweep::~CaseSweep() = default;

const SweepPlan& CaseSweep::plan() const { return combinations_->plan(); }

const std::string& CaseSweep::identity() const { return combinations_->identity(); }

SweepRun CaseSweep::run_one(std::size_t number) {
  if (number >= plan().size())
    throw InvalidInput("run " + std::to_string(number) + " is asked for", "the sweep has fewer",
                       "numbers are 0 to " + std::to_string(plan().size() - 1));
  SweepRun run = planned_run(plan(), number);
  try {
    run.summary = summary_of(*combinations_->of(number), run.seed);
  } catch (const InvalidInput& error) {
    run.refused = error.what();
  }
  return run;
}

std::vector<SweepRun> CaseSweep::run(const SweepOptions& options) {
  std::vector<SweepRun> runs(plan().size());
  std::vector<bool> known(runs.size(), false);
  for (const auto& run : options.known) {
    runs.at(run.number) = run;
    known[run.number] = true;
  }
  std::vector<std::size_t> to_make;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (!known[i]) to_make.push_back(i);

  std::mutex telling;
  std::size_t finished = runs.size() - to_make.size();
  for_each_index(to_make.size(), options.threads > 0 ? options.threads : processors(), [&](std::size_t i) {
    SweepRun& run = runs[to_make[i]];
    run = run_one(to_make[i]);
    const std::scoped_lock lock(telling);
    if (options.on_run) options.on_run(run);
    ++finished;
    if (options.progress)
      options.progress(fmt::format("run {} of {}", finished, runs.size()),
                       static_cast<double>(finished) / static_cast<double>(runs.size()));
  });
  return runs;
}

}  // namespace kalfem
