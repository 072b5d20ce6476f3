// SPDX-License-Identifier: Apache-2.0
#include "casefile/case_run.hpp"

#include <stdexcept>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/casefile/description.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/yaml/case_reader.hpp"

namespace kalfem::test {

Study study_of(const std::string& text, const std::string& file) {
  const Environment none = [](const std::string&) { return std::nullopt; };
  return make_study(read_case_text(text, file, description::case_schema(), none), file);
}

StudyResults results_of(const std::string& text, std::string_view verb) { return run_study(study_of(text), verb); }

std::string problems_of(const std::string& text) {
  try {
    study_of(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const auto place = text.find(from);
  if (place == std::string::npos) throw std::logic_error("the case does not hold: " + from);
  return text.replace(place, from.size(), to);
}

const Eigen::VectorXd& simulated(const StudyResults& results, const std::string& point, ObservedQuantity quantity) {
  const auto* found = find_quantity(results.get<SimulationOutcome>().points, point, quantity);
  if (!found) throw std::logic_error("nothing is simulated of " + point);
  return found->mean;
}

double difference(const Eigen::VectorXd& found, const Eigen::VectorXd& expected) {
  return (found - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

}  // namespace kalfem::test
