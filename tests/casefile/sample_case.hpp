// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <variant>

#include "kalfem/yaml/bounds.hpp"
#include "kalfem/yaml/case_reader.hpp"

/// A small study with every kind of field, on which the case-file machinery is tested.
namespace kalfem::sample {

enum class Method { newmark, exact };

struct Spring {
  std::string from, to;
  double stiffness = 0.0;
  bool operator==(const Spring&) const = default;
};
struct Substructure {
  Named<double> masses;
  std::vector<Spring> springs;
  std::vector<double> modal_damping;
  bool operator==(const Substructure&) const = default;
};
struct Connector {
  Located<std::string> from;
  std::string law;
  Named<Located<Quantity>> parameters;
  bool operator==(const Connector&) const = default;
};
struct RandomRoad {
  double rms = 0.0;
  std::array<double, 2> band{};
  std::uint64_t seed = 1;
  bool operator==(const RandomRoad&) const = default;
};
struct RecordedRoad {
  std::string file, channel;
  bool operator==(const RecordedRoad&) const = default;
};
struct Excitation {
  std::string base_displacement;
  std::variant<RandomRoad, RecordedRoad> signal;
  bool operator==(const Excitation&) const = default;
};
struct Simulation {
  double duration = 0.0;
  double sample_rate = 1000.0;
  Method method = Method::newmark;
  int iterations = 10;
  bool keep_states = false;
  std::optional<double> settling;
  bool operator==(const Simulation&) const = default;
};
struct Study {
  std::string title;
  Named<Substructure> substructures;
  Named<Connector> connectors;
  Named<Excitation> excitation;
  std::optional<Simulation> simulation;
  bool operator==(const Study&) const = default;
};

Schema<Study> study_schema();

extern const std::string valid_text;

/// No variable is set, so defaults are used.
Study read(const std::string& text);

/// All problems of a text, one a line; "" when there are none.
std::string problems(const std::string& text);

}  // namespace kalfem::sample
