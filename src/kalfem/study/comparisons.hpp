#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "kalfem/identification/filter_run.hpp"
#include "kalfem/study/updating_setup.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// One of the case's comparisons as a residual.
struct ComparisonResidual {
  std::string name;
  std::string kind;                             ///< in words: "natural frequencies of 'plane'"
  std::vector<ResidualPtr> continuation_steps;  ///< the same from smoothed to sharp; mostly there is one only
  double weight = 1.0;
  bool of_record = false;

  [[nodiscard]] const ResidualPtr& round(std::size_t number) const {
    return continuation_steps[std::min(number, continuation_steps.size() - 1)];
  }
};

/// Everything under `update.compare` that needs no record, in the order of the file. Throws InvalidInput with every
/// problem and its place.
std::vector<ComparisonResidual> make_comparisons(const Study& study,
                                                 const std::shared_ptr<const ParameterisedStructure>& structure);

/// Adds the others behind them. `record`: measured or simulated.
void add_record_comparisons(const Study& study, const FullRecord& record,
                            const std::shared_ptr<const ParameterisedStructure>& structure,
                            std::vector<ComparisonResidual>& comparisons);

/// Problems that show without computing: substructures and sensors that do not exist, comparisons that need a record.
void check_comparisons(const Study& study, IssueList& issues);
/// Problems of the comparisons that need the estimated motion of a boundary, once there is an augmented model. `start`:
/// the structure that the updating starts from.
void check_driven_histories(const Study& study, const CoupledModel& start, IssueList& issues);

}  // namespace kalfem
