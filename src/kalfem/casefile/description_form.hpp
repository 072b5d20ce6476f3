#pragma once

#include "kalfem/casefile/description.hpp"

namespace kalfem::description {

/// Forms of the parts, each in a file of its own beside description_form.cpp.
Form<Name> name();
Form<Value> value();
/// A point by its name, or a map of points and weights.
Form<Points> points(const std::string& short_name);

Form<FiniteElements> finite_elements();
Form<Reduction> reduction();
Form<Substructure> substructure();
Form<Excitation> excitation();
Form<Estimation> estimation();
Form<Updating> updating();
Form<Modification> modification();

}  // namespace kalfem::description
