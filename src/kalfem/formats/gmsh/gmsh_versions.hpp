#pragma once

#include "kalfem/formats/gmsh/gmsh_builder.hpp"
#include "kalfem/formats/gmsh/gmsh_scanner.hpp"

/// The sections of a Gmsh file as the versions 2.2 and 4.1 of the format write them; each reader begins behind the
/// section's first line and stops before its last one.
namespace kalfem::gmsh2 {

void read_nodes(GmshScanner& in, GmshBuilder& mesh);
void read_elements(GmshScanner& in, GmshBuilder& mesh);

}  // namespace kalfem::gmsh2

namespace kalfem::gmsh4 {

/// Groups (as the builder numbers them) of each entity, by its dimension and number.
using EntityGroups = std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>>;

void read_entities(GmshScanner& in, GmshBuilder& mesh, EntityGroups& groups);
void read_partitioned_entities(GmshScanner& in, GmshBuilder& mesh, EntityGroups& groups);
void read_nodes(GmshScanner& in, GmshBuilder& mesh);
void read_elements(GmshScanner& in, GmshBuilder& mesh, const EntityGroups& groups);

}  // namespace kalfem::gmsh4
