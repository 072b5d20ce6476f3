// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

namespace kalfem {
struct Study;
struct StudyResults;
enum class ObservedQuantity;
}  // namespace kalfem

/// Runs cases from their text, as the command does from a file. Who looks into a study or its results includes
/// study/study.hpp, steps/study_results.hpp or the outcome of a step.
namespace kalfem::test {

Study study_of(const std::string& text, const std::string& file = "case.yaml");

StudyResults results_of(const std::string& text, std::string_view verb = "predict");

/// What is wrong with a case, one problem a line; "" where it is accepted.
std::string problems_of(const std::string& text);

/// `text` with the first `from` in it changed to `to`; the text must hold it.
std::string changed(std::string text, const std::string& from, const std::string& to);

/// A simulated quantity of a point or connector.
const Eigen::VectorXd& simulated(const StudyResults& results, const std::string& point, ObservedQuantity quantity);

/// Largest difference to the largest value of the expected series.
double difference(const Eigen::VectorXd& found, const Eigen::VectorXd& expected);

}  // namespace kalfem::test
