// SPDX-License-Identifier: Apache-2.0
#include "kalfem/casefile/gravity.hpp"

#include "kalfem/base/units.hpp"

namespace kalfem::description {

void take_gravity(const CaseNode& node, std::initializer_list<const char*> path, Value& value) {
  if (value.value.dimension != parse_unit("g").dimension) return;
  const YamlNode* written = &node.yaml();
  for (const char* key : path) {
    const auto* entry = written->find(key);
    if (!entry) return;
    written = entry->value.get();
  }
  try {
    value.value = {to_si(written->text, "m/s^2"), parse_unit("m/s^2").dimension, false};
  } catch (const InvalidInput&) {
    return;  // another unit of mass, which is refused where the quantity is known
  }
}

}  // namespace kalfem::description
