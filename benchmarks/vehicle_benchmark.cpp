// SPDX-License-Identifier: Apache-2.0
// Time of one full-order step of the vehicle against one back-solve with its factor, medians of alternating blocks in
// one run, the reduction against its own factorisation and back-solves, and the augmented model against real time at
// its sampling rate and at half of it. Usage: vehicle_benchmark CASE.yaml
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "filter_walk.hpp"
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/dynamics/modal_coordinates.hpp"
#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/estimation/filter_choice.hpp"
#include "kalfem/linalg/blas.hpp"
#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/linalg/sparse_operations.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/yaml/case_reader.hpp"
#include "timing.hpp"

namespace {

using namespace kalfem;
using namespace kalfem::benchmarks;
using Eigen::Index;
using Eigen::VectorXd;

/// Seconds of a simulation of so many steps, sensors observed at each as a reference does.
double simulated(const Study& study, const OutputMap& sensors, double step, Index steps, FactorPrecision precision) {
  const auto& system = study.model->system();
  SimulationOptions options;
  options.integrator = Integrator::newmark;
  options.step = step;
  options.duration = step * static_cast<double>(steps);
  options.keep_motion = false;
  options.every_step = sensors;
  options.precision = precision;
  return seconds(
      [&] { simulate(system, study.structure->signals, at_rest(system.size(), system.connector_states()), options); });
}

/// Seconds of one step, without what comes before the first.
double time_of_step(const Study& study, const OutputMap& sensors, double step, FactorPrecision precision) {
  constexpr Index few = 50, many = 250;
  return (simulated(study, sensors, step, many, precision) - simulated(study, sensors, step, few, precision)) /
         double(many - few);
}

void time_steps(const Study& study) {
  const double step = 1.25e-4;
  std::vector<OutputDescription> outputs;
  for (const auto& sensor : study.sensors) outputs.push_back(sensor.output);
  const OutputMap sensors = make_outputs(*study.model, outputs);
  const auto split = split_damped_modes(study.model->system());
  const auto& system = split ? split->system : study.model->system();
  const SparseFactor factor(
      SparseMatrix(system.mass + 0.5 * step * system.damping + 0.25 * step * step * system.stiffness));
  VectorXd load = VectorXd::Random(factor.size()), solution = load;
  std::vector<double> solves, twofold, single;
  for (int block = 0; block < 7; ++block) {
    solves.push_back(seconds([&] {
                       for (int i = 0; i < 100; ++i) factor.solve(load, solution);
                     }) /
                     100.0);
    twofold.push_back(time_of_step(study, sensors, step, FactorPrecision::twofold));
    single.push_back(time_of_step(study, sensors, step, FactorPrecision::single));
  }
  line("degrees of freedom", double(study.model->system().size()), "");
  line("damped modes carried apart", split ? double(split->shapes.cols()) : 0.0, "");
  line("factor of the effective matrix", factor.bytes() / 1e6, "MB");
  line("one back-solve", 1e3 * median(solves), "ms");
  line("one full-order step in double precision", 1e3 * median(twofold), "ms");
  line("  with the factor in single precision", 1e3 * median(single), "ms");
  line("step / back-solve", median(twofold) / median(solves), "");
  line("  with the factor in single precision", median(single) / median(solves), "");
}

/// The frame as the study assembles it, at full order.
const FiniteElementPart& frame_of(const Study& study) { return *study.structure->finite_elements.front().part; }

void time_reduction(const FiniteElementPart& part) {
  std::vector<bool> held(part.full.dofs.size(), false);
  std::vector<std::string> boundary;
  for (const auto& node : part.nodes)
    if (node.name <= "p4")
      for (int direction = 0; direction < 6; ++direction) {
        const Index dof = part.assembled.find({node.node, direction});
        held[static_cast<std::size_t>(dof)] = true;
        boundary.push_back(part.full.dofs[static_cast<std::size_t>(dof)]);
      }
  std::vector<Index> interior;
  for (Index i = 0; i < part.full.size(); ++i)
    if (!held[static_cast<std::size_t>(i)]) interior.push_back(i);
  const SparseMatrix stiffness = select(part.full.stiffness, interior, interior);
  line("peak memory of reading, assembly and damping", memory_megabytes("VmHWM"), "MB");
  forget_peak();
  const double resident = memory_megabytes("VmRSS");
  (void)craig_bampton(part.full, boundary, {.modes = {.count = 60}, .error_indicators = false});
  const double peak = memory_megabytes("VmHWM");
  line("resident with the assembled model", resident, "MB");
  line("peak memory of the reduction, with that", peak, "MB");
  line("  without", peak - resident, "MB");
  std::vector<double> ratios;
  double memory = 0.0, own = 0.0, bare = 0.0;
  for (int repetition = 0; repetition < 5; ++repetition) {
    Superelement element;
    own = seconds(
        [&] { element = craig_bampton(part.full, boundary, {.modes = {.count = 60}, .error_indicators = false}); });
    const double factorisation = seconds([&] { memory = SparseFactor(stiffness).bytes(); });
    const SparseFactor factor(stiffness);
    VectorXd load = VectorXd::Random(factor.size()), solution = load;
    const auto count = static_cast<int>(element.error_indicators.solves);
    bare = factorisation + seconds([&] {
             for (int i = 0; i < count; ++i) factor.solve(load, solution);
           });
    ratios.push_back(own / bare);
  }
  line("Craig-Bampton, 24 + 60", own, "s");
  line("one factorisation and as many back-solves, alone", bare, "s");
  line("reduction / these", median(ratios), "");
  line("factor of K_ii", memory / 1e6, "MB");
  line("six times that", 6.0 * memory / 1e6, "MB");
}

/// The augmented model over noise of the sensors' size: its time does not depend on what it is told.
void time_augmented_model(const Study& study, const std::string& held) {
  constexpr Index samples = 1001, steps = 4000;
  const auto& setup = *study.augmented_model;
  std::vector<OutputDescription> outputs;
  std::vector<MeasurementChain> chains;
  for (const auto& sensor : setup.sensors) {
    outputs.push_back(sensor.output);
    chains.push_back(sensor.chain);
  }
  const auto l = static_cast<Index>(outputs.size());
  const FilterInput record{{.values = 0.1 * Eigen::MatrixXd::Random(l, samples)},
                           Eigen::MatrixXd::Zero(3 * setup.model->system().input_count(), samples),
                           0.01 * Eigen::MatrixXd::Identity(l, l)};
  const double rate = 1.0 / setup.options.step;
  for (const double share : {1.0, 0.5}) {
    auto options = setup.options;
    options.step = 1.0 / (share * rate);
    const auto choice = choose_filter({}, setup.model->system(), make_outputs(*setup.model, outputs), chains, options);
    FilterWalk walk(*choice.augmented_model, record, choice.filter);
    std::vector<double> times;
    for (Index i = 0; i < steps; ++i) {
      bool usable = true;
      times.push_back(seconds([&] { usable = walk.step(); }));
      if (!usable) return (void)std::printf("the filter's model failed\n");
    }
    std::printf("augmented model, %s, %d states, %4.0f Hz%*s %10.4g us, %.3g x real time\n", held.c_str(),
                static_cast<int>(choice.augmented_model->layout().size()), share * rate, 8, "", 1e6 * median(times),
                options.step / median(times));
  }
}

/// The case with all six directions of p1 to p4 in the frame's boundary and 60 modes.
Study with_whole_boundary(const std::string& file) {
  auto given = read_case(file, description::case_schema());
  auto& frame = std::ranges::find_if(given.substructures, [](const auto& each) {
                  return each.second.finite_elements.has_value();
                })->second;
  auto& reduction = frame.reduction.emplace().value;
  reduction.modes = 60;
  reduction.augmentation_vectors = false;
  for (const std::string point : {"p1", "p2", "p3", "p4"})
    for (const char* direction : {".x", ".y", ".z", ".rx", ".ry", ".rz"})
      reduction.boundary.push_back({point + direction, {}, ""});
  return make_study(std::move(given), file);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: vehicle_benchmark CASE.yaml\n"), 2;
  std::printf("%-58s %10s\n", "BLAS kernels", blas_kernels().c_str());
  time_reduction(frame_of(load_study(argv[1])));  // first, so that the memory is its own
  for (const char* modes : {"300", "600"}) {
    setenv("CUT_OFF", modes, 1);
    time_augmented_model(load_study(argv[1]), std::string("modes to ") + modes + " Hz");
  }
  time_augmented_model(with_whole_boundary(argv[1]), "24 of the boundary + 60 modes");
  unsetenv("CUT_OFF");
  time_steps(load_study(argv[1]));
  return 0;
}
