#include "kalfem/formats/abaqus/problems.hpp"

#include "kalfem/formats/included_text.hpp"

namespace kalfem::abaqus {

namespace {
constexpr std::size_t most_listed = 12;
}

int Problems::add_file(const std::string& name) {
  files_.push_back(name);
  return static_cast<int>(files_.size()) - 1;
}

void Problems::add(const Where& where, std::string what, std::string why, std::string fix) {
  if (where.file > 0) {
    what = without_quotations(what);
    why = without_quotations(why);
  }
  issues_.add(location(where), std::move(what), std::move(why), std::move(fix));
  if (issues_.issues().size() < most_listed) return;
  issues_.add(location(where), "reading stops here",
              "there are " + std::to_string(most_listed) + " problems up to this place", "mend them first");
  raise();
}

void Problems::fail(const Where& where, std::string what, std::string why, std::string fix) {
  add(where, std::move(what), std::move(why), std::move(fix));
  raise();
  throw InvalidInput(issues_.issues());
}

}  // namespace kalfem::abaqus
