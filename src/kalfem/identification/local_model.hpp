// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include "kalfem/identification/augmented_model_setup.hpp"

namespace kalfem {

/// Leaves only the local substructures, the connectors that touch them, and the interface in place of the rest. Works
/// on the parts that it is given and keeps a reference to them.
class LocalModel {
public:
  LocalModel(const LocalModelOptions& local, StructureParts& parts, IssueList& issues);

  void apply(AugmentedModelSetup& setup);
  /// Prior and noise of the interface inputs, once the number of inputs is known.
  void set_priors(AugmentedModelSetup& setup) const;

private:
  void check_names();
  void check_joints();
  [[nodiscard]] std::vector<std::string> grounds_left_out() const;
  void keep_grounds(const std::vector<std::string>& grounds);
  [[nodiscard]] bool remains(InputDescription& input) const;
  [[nodiscard]] bool reachable(const std::string& point) const;
  void add_interface(const std::string& point, const Located<Interface>& interface, AugmentedModelSetup& setup);
  void add_moving_point(const std::string& substructure, const std::string& point);

  const LocalModelOptions& local_;
  StructureParts& parts_;
  IssueList& issues_;
  std::set<std::string> kept_;
  std::vector<std::string> moving_;
};

}  // namespace kalfem
