// SPDX-License-Identifier: Apache-2.0
// How the time and memory of `modes` and of a Craig-Bampton reduction grow with a barrel of shells, each against one
// ordering, factorisation and block solves of the same matrices, alone. Each job is a process of its own, so that its
// peak is its own. Usage: scale_benchmark [AROUND RINGS]...; defaults give 44,220, 174,240 and 678,480 degrees of
// freedom.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>

#include "barrel.hpp"
#include "kalfem/base/freed_memory.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/identification/finite_element_part.hpp"
#include "kalfem/linalg/blas.hpp"
#include "timing.hpp"

namespace {

using namespace kalfem;
using namespace kalfem::benchmarks;
using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index modes_wanted = 26;
constexpr int points = 10, block_solves = 27, block_width = 8;
constexpr double cut_off = 400.0;  // [Hz]

using Figures = std::map<std::string, double>;

/// The figures of a job that runs in a process of its own, with its processor time and peak.
Figures in_own_process(const std::function<Figures()>& job) {
  int ends[2];
  if (pipe(ends) != 0) std::exit(1);
  if (fork() == 0) {
    Figures figures = job();
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    const auto seconds_of = [](const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); };
    figures["user"] = seconds_of(used.ru_utime);
    figures["kernel"] = seconds_of(used.ru_stime);
    figures["peak"] = memory_megabytes("VmHWM");
    FILE* pipe_end = fdopen(ends[1], "w");
    for (const auto& [name, value] : figures) std::fprintf(pipe_end, "%s\t%.17g\n", name.c_str(), value);
    std::fclose(pipe_end);
    std::_Exit(0);
  }
  close(ends[1]);
  Figures figures;
  FILE* pipe_end = fdopen(ends[0], "r");
  char name[64];
  double value = 0.0;
  while (std::fscanf(pipe_end, " %63[^\t] %lf", name, &value) == 2) figures[name] = value;
  std::fclose(pipe_end);
  int status = 0;
  wait(&status);
  if (status != 0) std::printf("a job ended with status %d\n", status);
  return figures;
}

FiniteElementPart part_of(const std::string& deck) {
  FiniteElementPart part{.name = "barrel"};
  part.times.measure("read", [&] { part.elements = read_deck(deck).model; });
  assemble_part(part, {.at_present_values = true});
  return part;
}

Figures modes_job(const std::string& deck) {
  Figures figures;
  figures["modes, whole job"] = seconds([&] {
    FiniteElementPart part = part_of(deck);
    NormalModes modes;
    part.times.measure("modes", [&] { modes = lowest_normal_modes(part.full, {modes_wanted}, part.factor.get()); });
    for (const auto& [phase, time] : part.times.list()) figures["modes: " + phase] = time;
    figures["degrees of freedom"] = double(part.full.size());
    figures["memory of L"] = part.factor->factor.bytes() / 1e6;
    figures["highest frequency"] = modes.frequencies.tail(1)[0];
  });
  return figures;
}

/// All six directions of nodes that are spread over the barrel.
std::vector<std::string> boundary_of(const FiniteElementPart& part) {
  std::vector<std::string> names;
  const Index nodes = part.full.size() / 6;
  for (int point = 0; point < points; ++point)
    for (Index direction = 0; direction < 6; ++direction)
      names.push_back(part.full.dofs[static_cast<std::size_t>(6 * (point * (nodes - 1) / (points - 1)) + direction)]);
  return names;
}

Figures reduction_job(const std::string& deck) {
  Figures figures;
  figures["reduction, whole job"] = seconds([&] {
    FiniteElementPart part = part_of(deck);
    part.boundary = boundary_of(part);
    const Superelement element = reduce(part, {.modes = {.cutoff = cut_off}}, 1.0);
    figures["reduction: superelement"] = element.error_indicators.seconds;
    figures["reduction: comparison"] = element.error_indicators.compare_seconds;
    figures["reduction: modes kept"] = double(element.error_indicators.fixed_interface_frequencies.size());
    figures["reduction: coordinates"] = double(element.model.size());
  });
  return figures;
}

/// One factorisation of K, held where it is free, and block solves with it.
Figures bare_job(const std::string& deck) {
  const FiniteElementPart part = part_of(deck);
  const Eigen::VectorXd springs = supports(part.full.stiffness, part.factor->rigid_modes);
  Figures figures;
  const double first = seconds([&] { (void)SparseFactor(part.full.stiffness, {}, springs); });
  const SparseFactor factor(part.full.stiffness, {}, springs);
  MatrixXd block = MatrixXd::Random(factor.size(), block_width), solution = block;
  const double solves = seconds([&] {
    for (int i = 0; i < block_solves; ++i) factor.solve(block, solution);
  });
  figures["bare: order and factor"] = first;
  figures["bare: 27 solves of 8 columns"] = solves;
  return figures;
}

void print_row(const std::string& what, const std::vector<Figures>& sizes, bool with_exponent) {
  std::printf("%-34s", what.c_str());
  for (const auto& figures : sizes) std::printf(" %11.4g", figures.at(what));
  for (std::size_t i = 1; with_exponent && i < sizes.size(); ++i)
    std::printf(" %9.2f", std::log(sizes[i].at(what) / sizes[i - 1].at(what)) /
                              std::log(sizes[i].at("degrees of freedom") / sizes[i - 1].at("degrees of freedom")));
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();  // as the command does
  std::vector<std::pair<int, int>> sizes = {{110, 67}, {220, 132}, {440, 257}};
  if (argc > 2) sizes.clear();
  for (int i = 1; i + 1 < argc; i += 2) sizes.emplace_back(std::atoi(argv[i]), std::atoi(argv[i + 1]));
  const std::string deck =
      (std::filesystem::temp_directory_path() / ("barrel_" + std::to_string(getpid()) + ".bdf")).string();
  std::vector<Figures> all;
  for (const auto& [around, rings] : sizes) {
    std::ofstream(deck) << barrel_deck(around, rings);
    Figures figures = in_own_process([&] { return modes_job(deck); });
    const double share = figures["kernel"] / (figures["kernel"] + figures["user"]);
    const double peak = figures["peak"];
    figures.merge(in_own_process([&] { return bare_job(deck); }));
    Figures reduction = in_own_process([&] { return reduction_job(deck); });
    figures["reduction: peak"] = reduction["peak"];
    figures.merge(reduction);
    const double bare = figures["bare: order and factor"] + figures["bare: 27 solves of 8 columns"];
    figures["modes: peak"] = peak;
    figures["modes / bare"] = figures["modes, whole job"] / bare;
    figures["reduction / bare"] = figures["reduction, whole job"] / bare;
    figures["modes: peak / memory of L"] = peak / figures["memory of L"];
    figures["modes: share of the kernel"] = share;
    all.push_back(std::move(figures));
  }
  std::filesystem::remove(deck);
  std::printf("BLAS kernels %s; seconds and MB; the last columns are exponents of growth\n", blas_kernels().c_str());
  print_row("degrees of freedom", all, false);
  for (const char* what :
       {"modes: read", "modes: assemble", "modes: factor", "modes: modes", "modes, whole job",
        "reduction: superelement", "reduction: comparison", "reduction, whole job", "bare: order and factor",
        "bare: 27 solves of 8 columns", "memory of L", "modes: peak", "reduction: peak"})
    print_row(what, all, true);
  for (const char* what : {"modes / bare", "reduction / bare", "modes: peak / memory of L",
                           "modes: share of the kernel", "reduction: modes kept", "reduction: coordinates"})
    print_row(what, all, false);
  return 0;
}
