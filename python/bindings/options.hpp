// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bindings.hpp"

namespace kalfem::python {

/// The options of an estimation from the arguments of Python, without the sensors. Throws InvalidInput with every
/// argument that does not fit, by its name.
EstimateOptions options_of(const Structure& structure, const py::dict& arguments);

/// {"masses": "1 %", "a1.delay": 2e-4}: percentages are relative, all else is in the number's unit.
std::vector<KnownTo> known_to_of(const py::dict& given);

/// The same of an updating. Records give their inputs to the structure.
UpdateOptions update_options_of(Structure& structure, const py::dict& arguments);

/// What an argument of that type is, in words.
template <class T>
const char* words_for() {
  if constexpr (std::is_same_v<T, bool>) return "True or False";
  if constexpr (std::is_same_v<T, std::string>) return "a text";
  if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::optional<double>>) return "a number";
  if constexpr (std::is_same_v<T, std::vector<std::string>>) return "a list of names";
  return "a whole number";
}

/// The argument as that type. Throws InvalidInput with its name where it is of another one.
template <class T>
T cast_of(const py::handle& given, const char* argument) try {
  return given.cast<T>();
} catch (const py::cast_error&) {
  throw InvalidInput(std::string(argument) + ": " + std::string(py::str(py::repr(given))) + " is given",
                     std::string(words_for<T>()) + " is needed", "");
}

/// The choice of that name. Throws InvalidInput with the argument and all names where there is none.
template <class T>
T choice_of(const std::string& argument, const py::handle& name,
            const std::vector<std::pair<std::string, T>>& choices) {
  const auto given = py::str(name).cast<std::string>();
  std::vector<std::string> names;
  std::string all;
  for (const auto& [each, choice] : choices) {
    if (each == given) return choice;
    names.push_back(each);
    all += (all.empty() ? "" : ", ") + each;
  }
  throw InvalidInput(argument + ": there is no '" + given + "' here" + did_you_mean(given, names), "",
                     "give one of " + all);
}

}  // namespace kalfem::python
