#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/formats/abaqus.hpp"
#include "kalfem/formats/abaqus/keyword.hpp"

namespace kalfem::abaqus {

/// The lines of a deck from front to back, without comments and with included files in their places.
class DeckLines {
public:
  DeckLines(std::string content, const std::string& source, const DeckLoader& loader, Problems& problems);

  /// The next keyword; data lines before it are passed over. False at the end of the deck.
  bool next_keyword(Keyword& keyword);
  /// The next data line of the present keyword; false where another keyword or the end follows. It is valid until the
  /// next call.
  bool next_data(std::string_view& line);
  /// The same, with blank lines: they stand for defaults under some keywords.
  bool next_data_or_blank(std::string_view& line);
  /// A data line that ends its file without a line end, and whether the file is the deck itself.
  struct OpenEnd {
    Where where;
    bool in_deck_itself = false;
  };
  [[nodiscard]] const std::vector<OpenEnd>& open_ends() const { return open_ends_; }
  /// Place of the line that was given last.
  [[nodiscard]] const Where& where() const { return where_; }
  /// Puts the content of a file before the next line (the parameter INPUT of some keywords).
  void insert(const std::string& name, const Where& where);
  /// A file beside the present one, or beside the deck itself.
  [[nodiscard]] std::string load(const std::string& name, const Where& where);

private:
  struct File {
    std::string path;
    std::string content;
    std::size_t at = 0;
    int index = 0;
    int line = 0;
  };
  enum class Kind { data, blank, keyword, end };

  Kind peek();
  bool read_line();
  std::string joined_keyword();
  bool follow_include();

  const DeckLoader& loader_;
  Problems& problems_;
  std::vector<std::unique_ptr<File>> files_;
  std::unique_ptr<File> closed_;  ///< its last line may still be in use
  std::string_view line_;
  bool pending_ = false;  ///< line_ has been read and not been given
  std::vector<OpenEnd> open_ends_;
  Where where_, line_where_;
};

}  // namespace kalfem::abaqus
