#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/study/study.hpp"

namespace kalfem {

/// Values that parameters have reached, by their names and by the names of all that they apply to.
using PresentValues = std::map<std::string, double>;

/// The names that an unknown applies to: its own where it does not say.
std::vector<description::Name> names_of(const std::string& name, const description::Unknown& given);

/// Builds the unknowns of an augmented model and releases the lumped elements among them from its parts.
class UnknownBuilder {
public:
  /// `parts`: what the augmented model holds. Unknowns go to `setup`, problems to `issues`.
  UnknownBuilder(const Study& study, const PresentValues& present, StructureParts& parts, AugmentedModelSetup& setup,
                 IssueList& issues)
      : study_(study), present_(present), parts_(parts), setup_(setup), issues_(issues) {}

  void add(const std::string& name, const description::Unknown& given);

private:
  struct Targets;
  [[nodiscard]] std::optional<Targets> found(const std::string& owner, const std::vector<description::Name>& names);
  void check_units(const std::string& owner, const std::vector<description::Name>& names, const Targets& targets);
  [[nodiscard]] bool holds(const StructureParameter& parameter) const;
  [[nodiscard]] std::vector<std::string> all_names() const;
  void add_target(const description::Name& name, UnknownParameter& unknown);
  [[nodiscard]] bool linear_part_follows(const Targets& targets) const;
  void add_linear(const std::vector<StructureParameter>& targets, const UnknownParameter& unknown);

  const Study& study_;
  const PresentValues& present_;
  StructureParts& parts_;
  AugmentedModelSetup& setup_;
  IssueList& issues_;
};

}  // namespace kalfem
