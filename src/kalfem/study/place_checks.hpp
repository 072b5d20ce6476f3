#pragma once

#include "kalfem/study/assembly.hpp"

namespace kalfem {

/// Points and grounds that connectors and excitations name: they must exist, a moving ground must be one, be driven
/// once and be felt by something, and a connector must not end at two grounds that stand still. Problems go to `issues`
/// with their place in the file.
void check_places(const description::Case& given, const StructureParts& parts, IssueList& issues);

}  // namespace kalfem
