// SPDX-License-Identifier: Apache-2.0
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::description {

using namespace schema;

namespace {

/// A file, or one of the matrices that a file holds.
Schema<FactorMatrix> factor_matrix() {
  const auto alone = path();
  const auto among = mapping(Fields<FactorMatrix>()
                                 .required("file", &FactorMatrix::file, path(), "file of several matrices")
                                 .required("name", &FactorMatrix::name, text(), "name of the matrix in it"));
  const auto read = [=](const CaseNode& node, FactorMatrix& given) {
    given = {};
    return node.yaml().kind == YamlNode::Kind::scalar ? alone.read(node, given.file) : among.read(node, given);
  };
  const auto write = [=](const FactorMatrix& given) {
    return given.name.empty() ? alone.write(given.file) : among.write(given);
  };
  return make_schema<FactorMatrix>(read, write, either_schema(alone.json_schema(), among.json_schema()));
}

Schema<MatricesOfFactor> matrices() {
  return mapping(
      Fields<MatricesOfFactor>()
          .optional("stiffness", &MatricesOfFactor::stiffness, factor_matrix(),
                    "K_i: a file as of `matrices`, or {file, name}")
          .optional("mass", &MatricesOfFactor::mass, factor_matrix(), "M_i likewise")
          .optional("damping", &MatricesOfFactor::damping, factor_matrix(), "C_i likewise")
          .optional("dofs", &MatricesOfFactor::dofs, located(path()),
                    "degrees of freedom of the rows, if the files do not state them; default: those of `matrices`")
          .optional("directions", &MatricesOfFactor::directions, integer(0, 6),
                    "directions per node, if `dofs` lists nodes only")
          .check([](const MatricesOfFactor& given) -> std::vector<Issue> {
            if (given.stiffness || given.mass || given.damping) return {};
            return {{{}, "no matrix is given", "a factor multiplies one", "give stiffness, mass or damping"}};
          }));
}

Fields<ElementsOfFactor> elements() {
  return Fields<ElementsOfFactor>()
      .required("elements", &ElementsOfFactor::elements, one_or_list(name()),
                "sets of elements, regions, materials, or numbers of elements such as 101-250")
      .optional("of", &ElementsOfFactor::of,
                choice<FactorOf>({{"stiffness", FactorOf::stiffness, "their stiffness"},
                                  {"mass", FactorOf::mass, "their mass"},
                                  {"both", FactorOf::both, "both by the same factor"}}),
                "what of the elements is multiplied");
}

}  // namespace

Schema<Factor> part_factor() {
  return mapping(Fields<Factor>()
                     .one_of(&Factor::part, when("matrices", matrices(), "matrices of files"), when(elements()))
                     .optional("value", &Factor::value, number("-"), "value of the factor in the structure as given"));
}

}  // namespace kalfem::description
