#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/casefile/description.hpp"
#include "kalfem/pipeline/reported_quantities.hpp"
#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/yaml/case_reader.hpp"

/// Runs cases from their text, as the command does from a file.
namespace kalfem::test {

inline Study study_of(const std::string& text, const std::string& file = "case.yaml") {
  const Environment none = [](const std::string&) { return std::nullopt; };
  return make_study(read_case_text(text, file, description::case_schema(), none), file);
}

inline StudyResults results_of(const std::string& text, Step last = Step::predict) {
  return run_study(study_of(text), last);
}

/// What is wrong with a case, one problem a line; "" where it is accepted.
inline std::string problems_of(const std::string& text) {
  try {
    study_of(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

/// `text` with the first `from` in it changed to `to`; the text must hold it.
inline std::string changed(std::string text, const std::string& from, const std::string& to) {
  const auto place = text.find(from);
  if (place == std::string::npos) throw std::logic_error("the case does not hold: " + from);
  return text.replace(place, from.size(), to);
}

/// A simulated quantity of a point or connector.
inline const Eigen::VectorXd& simulated(const StudyResults& results, const std::string& point,
                                        ObservedQuantity quantity) {
  const auto* found = find_quantity(results.simulation->points, point, quantity);
  if (!found) throw std::logic_error("nothing is simulated of " + point);
  return found->mean;
}

/// Largest difference to the largest value of the expected series.
inline double difference(const Eigen::VectorXd& found, const Eigen::VectorXd& expected) {
  return (found - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

}  // namespace kalfem::test
