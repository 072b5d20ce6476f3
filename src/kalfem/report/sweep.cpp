#include "kalfem/report/sweep.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "kalfem/base/hash.hpp"
#include "kalfem/base/parallel.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/pipeline/run_simulation.hpp"
#include "kalfem/report/data_files.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/report/summary_parts.hpp"

namespace kalfem {
namespace {

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

/// The case with the values of one combination, and its reference, for all seeds.
struct Combination {
  Study study;
  std::shared_ptr<const SimulationOutcome> simulation = {};  ///< empty: the case measures its record
  std::string failure = {};                                  ///< why there is no reference

  void simulate() {
    if (!study.simulation || simulation) return;
    std::vector<FieldSeries> pictures;
    simulation = std::make_shared<const SimulationOutcome>(run_simulation(study, {}, pictures, failure));
  }
};

/// The simulation with the noise of a seed; without a seed as it is.
std::shared_ptr<const SimulationOutcome> with_seed(const Combination& combination, std::optional<int> seed) {
  if (!seed) return combination.simulation;
  auto simulation = std::make_shared<SimulationOutcome>(*combination.simulation);
  add_noise(combination.study, static_cast<std::uint64_t>(*seed), *simulation);
  return simulation;
}

/// What does not depend on the machine, in one line.
std::string lasting_text(nlohmann::ordered_json summary) {
  drop_times(summary);
  summary["files"] = nlohmann::ordered_json::array();
  return summary.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
}

std::string summary_of(const Combination& combination, std::optional<int> seed) {
  const Study& study = combination.study;
  StudyResults results;
  if (combination.failure.empty())
    results = run_study(study, Step::everything, {.simulation = with_seed(combination, seed)});
  else
    results.failure = combination.failure;
  return lasting_text(summarise(study, results));
}

std::size_t seeds_of(const SweepPlan& plan) { return static_cast<std::size_t>(std::max(1, plan.seeds)); }

std::vector<SweepRun> planned_runs(const SweepPlan& plan) {
  std::vector<SweepRun> runs(plan.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    runs[i].number = i;
    runs[i].values = plan.values(i / seeds_of(plan));
    if (plan.seeds > 0) runs[i].seed = static_cast<int>(i % seeds_of(plan)) + 1;
  }
  return runs;
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

/// Combinations, each made by the first run that asks for it and dropped after its last run.
class Sweep::Combinations {
public:
  explicit Combinations(SweepPlan plan) : plan_(std::move(plan)), places_(plan_.combinations()) {
    places_.front().made = std::make_shared<Combination>(Combination{read(0)});
  }

  [[nodiscard]] const SweepPlan& plan() const { return plan_; }
  /// Of the first combination, before the runs.
  [[nodiscard]] const Study& first() const { return places_.front().made->study; }

  /// Announces a run that will ask for its combination.
  void expect(std::size_t run) { ++place_of(run).runs; }

  /// The combination of a run, simulated. Throws InvalidInput, for each of its runs, where the case cannot be read.
  std::shared_ptr<const Combination> of(std::size_t run) {
    Place& place = place_of(run);
    const std::scoped_lock lock(place.guard);
    if (place.refused) throw InvalidInput(*place.refused);
    try {
      if (!place.made) place.made = std::make_shared<Combination>(Combination{read(run / seeds_of(plan_))});
      place.made->simulate();
    } catch (const InvalidInput& error) {
      place.refused = error;
      throw;
    }
    std::shared_ptr<const Combination> made = place.made;
    if (--place.runs == 0) place.made = nullptr;
    return made;
  }

private:
  struct Place {
    std::mutex guard;
    std::shared_ptr<Combination> made;  ///< changed under the guard, before it is handed out
    std::optional<InvalidInput> refused;
    std::size_t runs = 0;  ///< that will ask for it
  };

  Place& place_of(std::size_t run) { return places_[run / seeds_of(plan_)]; }

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
  std::vector<Place> places_;
  std::mutex reading_;
};

Sweep::Sweep(SweepPlan plan) {
  check(plan);
  combinations_ = std::make_unique<Combinations>(std::move(plan));
}

Sweep::~Sweep() = default;

const SweepPlan& Sweep::plan() const { return combinations_->plan(); }

std::string Sweep::identity() const {
  Hash hash;
  const Study& study = combinations_->first();
  hash.add(version);
  hash.add(study.resolved_case);
  for (const auto& file : data_files(study)) hash.add(file.sha256);
  for (const auto& [key, value] : plan().changes) hash.add(key + "=" + value.value_or("") + "\n");
  for (const auto& axis : plan().axes) hash.add(fmt::format("{}={}\n", axis.key, fmt::join(axis.values, "\n")));
  hash.add(std::to_string(plan().seeds));
  return fmt::format("{:016x}", hash.value());
}

std::vector<SweepRun> Sweep::run(const SweepOptions& options) {
  std::vector<SweepRun> runs = planned_runs(plan());
  std::vector<bool> known(runs.size(), false);
  for (const auto& run : options.known) {
    runs.at(run.number) = run;
    known[run.number] = true;
  }
  std::vector<std::size_t> to_make;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (!known[i]) to_make.push_back(i);
  for (const auto run : to_make) combinations_->expect(run);

  std::mutex telling;
  std::size_t finished = runs.size() - to_make.size();
  for_each_index(to_make.size(), options.threads > 0 ? options.threads : processors(), [&](std::size_t i) {
    SweepRun& run = runs[to_make[i]];
    try {
      run.summary = summary_of(*combinations_->of(run.number), run.seed);
    } catch (const InvalidInput& error) {
      run.refused = error.what();
    }
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
