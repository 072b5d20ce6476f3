#pragma once

#include <string>
#include <string_view>

namespace kalfem::abaqus {

/// What the reader does with a keyword that has no function of its own in it.
enum class KeywordUse {
  stored,           ///< kept with its data lines, used when the model is put together
  option,           ///< belongs to the stored keyword before it
  material_option,  ///< belongs to the material before it
  silent,           ///< output and comments: nothing is lost
  noted,            ///< no part of the result, for a note
  doubtful,         ///< may change the model, for a note that warns
  lacking,          ///< a connection, or not known: the model lacks it, which the user may accept
  missing           ///< nothing that the model could do without: a problem
};

struct KeywordClass {
  KeywordUse use = KeywordUse::noted;
  std::string consequence = {};  ///< for a note, or why the model would be incomplete
};

/// `name` as of Keyword: capitals without blanks.
KeywordClass classify(std::string_view name);

}  // namespace kalfem::abaqus
