// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/state_file.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/hash.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/base/version.hpp"

namespace kalfem {
namespace {

/// FNV-1a over words of eight bytes, the last one filled up with zeros: a state is written every second.
std::string hash_of(std::string_view bytes) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (std::size_t place = 0; place < bytes.size(); place += sizeof hash) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + place, std::min(sizeof word, bytes.size() - place));
    hash = (hash ^ word) * 1099511628211ULL;
  }
  return std::to_string(hash);
}

void add(Hash& hash, const SparseMatrix& matrix) {
  for (Eigen::Index column = 0; column < matrix.outerSize(); ++column)
    for (SparseMatrix::InnerIterator entry(matrix, column); entry; ++entry)
      for (const double value : {static_cast<double>(entry.row()), static_cast<double>(entry.col()), entry.value()})
        hash.add(value);
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why, const std::string& fix) {
  throw InvalidInput("the state in " + file.string() + " cannot be taken up", why, fix);
}

}  // namespace

std::string state_fingerprint(const FilterProblem& problem, const OnlineOptions& options) {
  Hash hash;
  hash.add(version);
  const auto& system = problem.setup.model->system();
  for (const auto* matrix : {&system.mass, &system.damping, &system.stiffness}) add(hash, *matrix);
  for (const auto& sensor : problem.setup.sensors) {
    hash.add(sensor.name);
    hash.add(sensor.noise);
    for (const auto& [point, weight] : sensor.output.points) {
      hash.add(point);
      hash.add(weight);
    }
  }
  const auto& settings = problem.problem->settings;
  for (const auto& unknown : settings.unknowns) {
    hash.add(unknown.name);
    for (const double number : {unknown.initial, unknown.deviation, unknown.random_walk}) hash.add(number);
  }
  for (const double number :
       {problem.problem->sample_rate, settings.process_noise.acceleration, double(settings.substeps.value_or(0)),
        double(settings.step_order), double(options.input_delay), double(options.window),
        double(options.gates ? options.gates->memory : 0)})
    hash.add(number);
  if (options.lag > 0) hash.add(double(options.lag));
  if (const auto& changes = options.changes) {
    for (const double number : {changes->window, double(changes->reference), double(changes->memory), changes->level,
                                changes->hysteresis, double(changes->persistence), changes->false_alarms_every})
      hash.add(number);
    for (const auto& [name, effect] : changes->covariates) {
      hash.add(name);
      hash.add(effect);
    }
  }
  return std::to_string(hash.value());
}

void write_state_file(const std::filesystem::path& file, const std::string& fingerprint, const Resumable& state) {
  std::error_code none_yet;
  const auto size = std::filesystem::file_size(file, none_yet);  // of the state before, which is about as long
  ArchiveWriter inner(none_yet ? 0 : size), outer(none_yet ? 0 : size);
  state.keep(inner);
  const std::string content = inner.take();
  outer(fingerprint);
  outer(content);
  outer(hash_of(content));
  write_file_atomically(file, std::string(state_magic) + outer.take());
}

void read_state_file(const std::filesystem::path& file, const std::string& fingerprint, Resumable& state) {
  if (std::error_code error; !std::filesystem::is_regular_file(file, error))
    refuse(file, "there is no such file", "give the file that was written");
  const std::string whole = bytes_if_readable(file);
  const char* const damaged = "the file is damaged or is no state of kalfem";
  if (!whole.starts_with(state_magic)) refuse(file, damaged, "remove it to begin anew");
  try {
    std::string of, content, hash;
    ArchiveReader outer(std::string_view(whole).substr(state_magic.size()));
    outer(of);
    outer(content);
    outer(hash);
    if (!outer.at_end() || hash != hash_of(content)) throw DamagedArchive();
    if (of != fingerprint)
      refuse(file, "it belongs to another structure, other options or another version of kalfem",
             "remove it to begin anew");
    ArchiveReader inner(content);
    state.take_up(inner);
    if (!inner.at_end()) throw DamagedArchive();
  } catch (const DamagedArchive&) {
    refuse(file, damaged, "remove it to begin anew");
  }
}

}  // namespace kalfem
