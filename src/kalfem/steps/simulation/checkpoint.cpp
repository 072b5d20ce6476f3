// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/simulation/checkpoint.hpp"

#include <concepts>
#include <sstream>
#include <type_traits>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/binary_archive.hpp"
#include "kalfem/base/hash.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/steps/field_series.hpp"
#include "kalfem/steps/reported_quantities.hpp"
#include "kalfem/steps/run_study.hpp"

// The file: the fingerprint, every member of the simulation in the order of transfer(), and a hash of all that. One
// function describes the members for both directions, so that what is written is what is read.
namespace kalfem {
namespace {

using Eigen::Index;

constexpr double worth_keeping = 1.0;  ///< [s]

/// A T that is written, or that is read.
template <class Given, class T>
concept Some = std::same_as<std::remove_const_t<Given>, T>;

void transfer(auto& archive, Some<PointQuantity> auto& quantity) {
  archive(quantity.point);
  archive(quantity.quantity);
  archive(quantity.mean);
  archive(quantity.deviation);
  archive(quantity.truth);
  archive(quantity.nrmse);
  archive(quantity.nrmse_in_band);
}

void transfer(auto& archive, Some<Channel> auto& channel) {
  archive(channel.name);
  archive(channel.unit);
  archive(channel.noise);
}

void transfer(auto& archive, Some<FieldSeries> auto& series) {
  archive(series.name);
  archive(series.substructure);
  archive(series.times);
  archive(series.displacement);
}

void transfer(auto& archive, Some<Trajectory> auto& trajectory) {
  archive(trajectory.step);
  archive(trajectory.displacement);
  archive(trajectory.velocity);
  archive(trajectory.acceleration);
  archive(trajectory.force);
  archive(trajectory.inputs);
  archive(trajectory.connector_states);
}

/// Of a simulation that did not fail.
void transfer(auto& archive, Some<ConvergedSolution> auto& solution) {
  transfer(archive, solution.simulation.trajectory);
  archive(solution.simulation.every_step);
  archive(solution.simulation.every_sample);
  archive(solution.simulation.solve_error);
  archive(solution.sensors);
  archive(solution.substeps);
  archive(solution.extrapolations);
  archive(solution.last_change);
  archive(solution.converged);
  archive(solution.changes);
}

void transfer(auto& archive, Some<Record> auto& record) {
  archive(record.sample_rate);
  archive(record.start);
  archive.each(record.channels, [&](auto& item) { transfer(archive, item); });
  archive(record.values);
  archive(record.used);
}

void transfer(auto& archive, Some<SimulationOutcome> auto& simulation) {
  transfer(archive, simulation.reference);
  transfer(archive, simulation.measurements);
  archive.each(simulation.points, [&](auto& item) { transfer(archive, item); });
  archive.each(simulation.fields, [&](auto& item) { transfer(archive, item); });
}

std::string hash_of(std::string_view bytes) {
  Hash hash;
  hash.add(bytes);
  return std::to_string(hash.value());
}

void add(Hash& hash, const SparseMatrix& matrix) {
  for (Index column = 0; column < matrix.outerSize(); ++column)
    for (SparseMatrix::InnerIterator entry(matrix, column); entry; ++entry) {
      hash.add(static_cast<double>(entry.row()));
      hash.add(static_cast<double>(entry.col()));
      hash.add(entry.value());
    }
}

/// The case with all its defaults, without the section that only the filter reads. A line that is not indented begins a
/// section.
std::string simulated_case(const Study& study) {
  std::istringstream lines(study.resolved_case);
  std::string text;
  bool of_estimate = false;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(' ')) of_estimate = line.starts_with("estimate:");
    if (!of_estimate) text += line + "\n";
  }
  return text;
}

}  // namespace

std::string simulation_fingerprint(const Study& study) {
  Hash hash;
  hash.add(version);
  hash.add(simulated_case(study));
  const auto& system = study.model->system();
  for (const auto* matrix : {&system.mass, &system.damping, &system.stiffness}) add(hash, *matrix);
  for (const auto& quantity : reported_quantities(*study.model)) hash.add(quantity.name + "\n");
  const SimulationPlan& plan = *study.simulation;
  const auto samples = static_cast<Index>(plan.duration * plan.sample_rate) + 1;
  for (const auto& signal : study.structure->signals) {
    const SignalSamples excitation = signal->sample(0.0, 1.0 / plan.sample_rate, samples);
    for (const double value : excitation.reshaped()) hash.add(value);
  }
  return std::to_string(hash.value());
}

SimulationCheckpoint::SimulationCheckpoint(const std::filesystem::path& folder, const Study& study)
    : file_(folder.empty() ? folder : folder / simulation_name),
      fingerprint_(folder.empty() ? "" : simulation_fingerprint(study)) {}

std::optional<SimulationOutcome> SimulationCheckpoint::read() const {
  if (std::error_code error; file_.empty() || !std::filesystem::is_regular_file(file_, error)) return std::nullopt;
  const std::string whole = bytes_if_readable(file_);
  try {
    SimulationOutcome simulation;
    std::string fingerprint, content, hash;
    ArchiveReader outer(whole);
    outer(fingerprint);
    if (fingerprint != fingerprint_) return std::nullopt;
    outer(content);
    outer(hash);
    if (!outer.at_end() || hash != hash_of(content)) return std::nullopt;
    ArchiveReader inner(content);
    transfer(inner, simulation);
    return simulation;
  } catch (const DamagedArchive&) {
    return std::nullopt;
  }
}

void SimulationCheckpoint::write(const SimulationOutcome& simulation) const {
  if (file_.empty() || simulation.seconds < worth_keeping) return;
  ArchiveWriter inner, outer;
  transfer(inner, simulation);
  const std::string content = inner.take();
  outer(fingerprint_);
  outer(content);
  outer(hash_of(content));
  write_file_atomically(file_, outer.take());
}

}  // namespace kalfem
