// SPDX-License-Identifier: Apache-2.0
// Nastran DMIG entries of a bulk data or punch file, in small, large or free fields:
//   DMIG NAME 0 form type-in type-out polar - columns          the header of a matrix
//   DMIG NAME GJ CJ - G1 C1 A1 B1  G2 C2 A2 B2 ...             one column of it
// Component 0 is a scalar or extra point: a generalised coordinate. Other entries of the file are passed over.

#include <algorithm>
#include <map>

#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/single_formats.hpp"
#include "kalfem/formats/nastran/card_stream.hpp"

namespace kalfem {
namespace {

struct Header {
  int form = 0;
  int line = 0;
};

// Reads the cards through the stream of the bulk data reader, which joins continuations and splits small, large and
// free fields. Square matrices gather their entries by degree of freedom, as their rows and columns are the same
// list.
// Rectangular ones are numbered at the end, when all rows and columns are known. Matrices keep the order of their
// headers.
class DmigReader {
public:
  DmigReader(std::string_view text, const std::string& source) : text_(text), bytes_(text.size()), source_(source) {}

  std::vector<ForeignMatrix> read() {
    nastran::DeckFiles files;
    nastran::DeckLines lines(std::string(text_), source_, refuse_include, files);
    nastran::CardStream cards(files, [this](const nastran::Card& card) {
      card_ = &card;
      if (card.name == "DMIG") interpret();
    });
    while (const auto line = lines.next()) cards.line(*line);
    cards.finish();
    files.raise();
    std::vector<ForeignMatrix> matrices;
    for (const auto& name : order_) matrices.push_back(finished(name));
    if (matrices.empty()) refuse(0, "the file has no DMIG matrix", "a DMIG header and columns are required");
    return matrices;
  }

private:
  static std::string refuse_include(const std::filesystem::path& file) {
    throw InvalidInput("the file includes '" + file.string() + "'", "included files are not read",
                       "add that file to the list");
  }

  /// Field of the present card: 0 is the name of the matrix.
  [[nodiscard]] std::string field(std::size_t i) const { return std::string(card_->raw(i + 1)); }

  void interpret() {
    const std::string name = field(0);
    if (name.empty()) refuse(card_->place.line, "a DMIG entry has no name", "its second field must name the matrix");
    if (field(1) == "0") {
      add_header(name);
      return;
    }
    const auto header = headers_.find(name);
    if (header == headers_.end())
      refuse(card_->place.line, "a column of matrix '" + name + "' has no header before it",
             "the header states whether the matrix is symmetric", "put 'DMIG, " + name + ", 0, 6, 2, 0' before it");
    add_column(name, header->second.form);
  }

  void add_header(const std::string& name) {
    const std::int64_t form = whole(2, "form"), type = whole(3, "type");
    if (form != 1 && form != 2 && form != 6 && form != 9)
      refuse(card_->place.line, "matrix '" + name + "' has form " + std::to_string(form),
             "it must be 1 (square), 2 or 9 (rectangular) or 6 (symmetric)");
    if (type == 3 || type == 4)
      refuse(card_->place.line, "matrix '" + name + "' is complex", "only real matrices are supported",
             "export stiffness and damping as real matrices");
    if (type != 1 && type != 2)
      refuse(card_->place.line, "matrix '" + name + "' has type " + std::to_string(type), "it must be 1 or 2 (real)");
    refuse_beyond_header(name);
    if (!headers_.try_emplace(name, Header{static_cast<int>(form), card_->place.line}).second)
      refuse(card_->place.line, "matrix '" + name + "' has two headers", "it is not clear which one applies");
    order_.push_back(name);
    if (form == 1 || form == 6) square_.try_emplace(name, source_, name);
  }

  // A column card holds groups of four fields G, C, A, B: point, component, real and imaginary part. A group without
  // point and value is a gap in the card. In form 9 the column is a plain number without component.
  void add_column(const std::string& name, int form) {
    if (!field(3).empty()) refuse_field(name, 3);
    const bool numbered = form == 9;
    MatrixDof column{whole(1, "column's point"), 0};
    if (!numbered) column = dof(1, 2);
    for (std::size_t i = 4; i < card_->size(); i += 4) {
      if (field(i).empty() && field(i + 1).empty() && field(i + 2).empty() && field(i + 3).empty()) continue;
      const MatrixDof row = dof(i, i + 1);
      const auto value = fortran_number(field(i + 2));
      if (!value)
        refuse(card_->place.line, "'" + field(i + 2) + "' in matrix '" + name + "' is not a number",
               "an entry is expected here");
      if (!field(i + 3).empty() && fortran_number(field(i + 3)) != 0.0)
        refuse(card_->place.line, "an entry of matrix '" + name + "' has an imaginary part",
               "only real matrices are supported");
      if (form == 1 || form == 6)
        square_.at(name).add(row, column, *value, card_->place.line);
      else
        rectangular_[name].push_back({row, column, *value, card_->place.line});
    }
  }

  // TOUT, POLAR and the number of columns (fields 4, 5 and 7) concern output and complex matrices.
  /// A field of a header that has no meaning.
  void refuse_beyond_header(const std::string& name) const {
    for (std::size_t i = 6; i < card_->size(); ++i)
      if (i != 7 && !field(i).empty()) refuse_field(name, i);
  }
  [[noreturn]] void refuse_field(const std::string& name, std::size_t i) const {
    refuse(card_->place.line,
           "'" + field(i) + "' in " + nastran::place_on_card(i + 1) + " of matrix '" + name +
               "' stands where DMIG has no field",
           "an entry may be out of its place", "correct the card");
  }

  [[nodiscard]] MatrixDof dof(std::size_t point, std::size_t component) const {
    const std::int64_t number = whole(point, "point");
    const std::int64_t direction = field(component).empty() ? 0 : whole(component, "component");
    if (number < 1 || direction < 0 || direction > 6)
      refuse(card_->place.line,
             "point " + std::to_string(number) + ", component " + std::to_string(direction) +
                 " is not a degree of freedom",
             "points are > 0; components are 1 ... 6, or 0 for scalar points");
    return {number, static_cast<int>(direction) - 1};
  }

  [[nodiscard]] std::int64_t whole(std::size_t i, const std::string& meaning) const {
    const auto value = whole_number(field(i));
    if (!value) refuse(card_->place.line, "'" + field(i) + "' is no " + meaning, "a whole number is expected here");
    return *value;
  }

  // Form 6 states each pair of off-diagonal entries once, so the other triangle is filled in.
  [[nodiscard]] ForeignMatrix finished(const std::string& name) const {
    const Header header = headers_.at(name);
    if (header.form == 6) return nonempty(square_.at(name).finish(Storage::one_triangle, bytes_), header);
    if (header.form == 1) return nonempty(square_.at(name).finish(Storage::full, bytes_), header);
    return rectangle(name, header);
  }

  /// Rows by degree of freedom; columns in ascending order of their points.
  [[nodiscard]] ForeignMatrix rectangle(const std::string& name, const Header& header) const {
    const auto found = rectangular_.find(name);
    if (found == rectangular_.end()) return nonempty({name, {}, {}, false}, header);
    std::map<MatrixDof, std::int64_t> rows, columns;
    for (const auto& entry : found->second) rows[entry.row], columns[entry.column];
    const auto number = [](auto& places) {
      std::int64_t next = 0;
      for (auto& [dof, place] : places) place = next++;
      return next;
    };
    const std::int64_t height = number(rows), width = number(columns);
    MatrixEntries entries(source_, name, height, width, bytes_, header.line);
    for (const auto& entry : found->second)
      entries.add(rows.at(entry.row), columns.at(entry.column), entry.value, entry.line);
    ForeignMatrix matrix = entries.finish(Storage::full);
    for (const auto& [dof, place] : rows) matrix.dofs.push_back(dof);
    return matrix;
  }

  [[nodiscard]] ForeignMatrix nonempty(ForeignMatrix matrix, const Header& header) const {
    if (matrix.matrix.rows() == 0)
      refuse(header.line, "matrix '" + matrix.name + "' has a header but no columns", "its entries are missing");
    return matrix;
  }

  [[noreturn]] void refuse(int line, std::string what, std::string why, std::string fix = {}) const {
    refuse_matrix(source_, line, std::move(what), std::move(why), std::move(fix));
  }

  struct Entry {
    MatrixDof row, column;
    double value;
    int line;
  };

  std::string_view text_;
  std::size_t bytes_;
  const std::string& source_;
  const nastran::Card* card_ = nullptr;
  std::map<std::string, Header> headers_;
  std::vector<std::string> order_;
  std::map<std::string, NodalEntries> square_;
  std::map<std::string, std::vector<Entry>> rectangular_;
};

}  // namespace

std::vector<ForeignMatrix> parse_dmig(std::string_view text, const std::string& source) {
  return DmigReader(text, source).read();
}

}  // namespace kalfem
