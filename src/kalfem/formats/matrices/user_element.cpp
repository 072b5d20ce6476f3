// SPDX-License-Identifier: Apache-2.0
// *USER ELEMENT, LINEAR with *MATRIX, TYPE=STIFFNESS or MASS: the substructures of Abaqus and CalculiX as they write
// them with *SUBSTRUCTURE MATRIX OUTPUT. The nodes stand in comments below "** ELEMENT NODES"; data lines of *USER
// ELEMENT give the directions of the first node, and then "position, directions" where they change; a symmetric matrix
// is given column by column down to its diagonal.

#include <algorithm>

#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/single_formats.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

// One pass over the lines. A keyword closes the matrix before it, since only the keyword tells that its values have
// ended. Node numbers come from comments, because the element itself numbers its nodes 1 ... n; without these
// comments the matrix could not be joined to a mesh.
class UserElementReader {
public:
  UserElementReader(std::string_view text, const std::string& source)
      : lines_(text), bytes_(text.size()), source_(source) {}

  std::vector<ForeignMatrix> read() {
    while (const auto line = lines_.next()) {
      if (line->starts_with("**")) {
        comment(line->substr(2));
      } else if (line->starts_with('*')) {
        keyword(*line);
      } else if (const auto words = number_words(*line); !words.empty()) {
        data(words);
      }
    }
    finish_matrix();
    if (matrices_.empty()) refuse("the file has no matrix", "*MATRIX, TYPE=STIFFNESS or TYPE=MASS is required");
    if (!others_.empty()) matrices_.front().notes.push_back("keywords that are not used: " + others_);
    return std::move(matrices_);
  }

private:
  enum class Block { none, element, matrix, other };

  // Comments outside of the list of nodes are ignored, and one that is no list of numbers ends it.
  void comment(std::string_view text) {
    if (lower_case(text).find("element nodes") != std::string::npos) {
      in_nodes_ = true;
      nodes_.clear();
      return;
    }
    if (!in_nodes_) return;
    std::vector<std::int64_t> numbers;
    for (const auto word : number_words(text)) {
      const auto number = whole_number(word);
      if (!number) {
        in_nodes_ = false;
        return;
      }
      numbers.push_back(*number);
    }
    nodes_.insert(nodes_.end(), numbers.begin(), numbers.end());
  }

  // Fixes the rows at *MATRIX: by then the comments and data lines of *USER ELEMENT are complete. Blanks and letter
  // case do not count in keywords.
  void keyword(std::string_view line) {
    finish_matrix();
    in_nodes_ = false;
    std::string text = lower_case(line);
    std::erase_if(text, [](char c) { return c == ' ' || c == '\t'; });
    block_ = Block::none;
    if (text.starts_with("*userelement")) {
      block_ = Block::element;
      changes_.clear();
      nodes_.clear();
      const std::size_t at = text.find(",nodes=");
      const auto count = at == std::string::npos
                             ? std::nullopt
                             : whole_number(std::string_view(text).substr(at + 7, text.find(',', at + 7) - at - 7));
      if (!count || *count < 1 || *count > static_cast<std::int64_t>(bytes_))
        refuse("*USER ELEMENT does not state how many nodes it has", "NODES= is required");
      count_ = static_cast<std::size_t>(*count);
      unsymmetric_ = text.find(",unsymm") != std::string::npos;
      require_parameters(line, {"nodes", "unsymm", "linear", "type"});
    } else if (text.starts_with("*matrix,")) {
      require_parameters(line, {"type"});
      block_ = Block::matrix;
      const std::size_t at = text.find("type=");
      name_ = at == std::string::npos ? "matrix" : text.substr(at + 5, text.find(',', at) - at - 5);
      dofs_ = element_dofs();
    } else if (text.starts_with("*cload") || text.starts_with("*sload") || text.starts_with("*heading")) {
      block_ = Block::other;
      const std::string name = text.substr(0, text.find(','));
      if (others_.find(name) == std::string::npos) others_ += (others_.empty() ? "" : ", ") + name;
    } else {
      refuse("the keyword '" + std::string(trimmed(line)).substr(0, 40) + "' is not known here",
             "what it adds to the matrices would be lost",
             "keep *USER ELEMENT and *MATRIX, as the other code writes them");
    }
  }

  void require_parameters(std::string_view line, std::initializer_list<std::string_view> known) const {
    if (const auto other = unknown_parameter(line, known))
      refuse("the parameter '" + *other + "' is not known", "what it means for the matrices is not either",
             "remove it if it has no effect");
  }

  // Values of a matrix run on over as many lines as they need. Lines of *USER ELEMENT list the active directions: the
  // first line those of node 1, each later one a node position and the directions that hold from there on.
  void data(const std::vector<std::string_view>& words) {
    in_nodes_ = false;
    if (block_ == Block::matrix) {
      for (const auto word : words) {
        const auto value = fortran_number(word);
        if (!value)
          refuse("'" + std::string(word.substr(0, 40)) + "' is not a number",
                 "an entry of the matrix is expected here");
        values_.emplace_back(*value, lines_.number());
      }
    } else if (block_ == Block::element) {
      std::vector<std::int64_t> numbers;
      for (const auto word : words) {
        const auto number = whole_number(word);
        if (!number)
          refuse("'" + std::string(word.substr(0, 40)) + "' is not a whole number", "directions must be whole numbers");
        numbers.push_back(*number);
      }
      if (!changes_.empty() && numbers.size() < 2)
        refuse("a line of *USER ELEMENT has only one number", "a node's position and its directions are required");
      const std::int64_t position = changes_.empty() ? 1 : numbers.front();
      const std::size_t skip = changes_.empty() ? 0 : 1;
      changes_.push_back({position, {numbers.begin() + static_cast<std::ptrdiff_t>(skip), numbers.end()}});
    } else if (block_ == Block::none) {
      refuse("the line belongs to no keyword", "it stands before *USER ELEMENT", "remove it, or make it a comment");
    }
  }

  /// Rows of the matrix: the directions that hold at each node, in the order of the nodes.
  [[nodiscard]] std::vector<MatrixDof> element_dofs() const {
    if (nodes_.size() != count_)
      refuse("*USER ELEMENT has " + std::to_string(count_) + " nodes, of which " + std::to_string(nodes_.size()) +
                 " have a number",
             "the comment '** ELEMENT NODES' must list their numbers", "keep the comments of the file");
    std::vector<MatrixDof> dofs;
    std::vector<std::int64_t> directions;
    std::size_t change = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      while (change < changes_.size() && changes_[change].position == static_cast<std::int64_t>(i) + 1)
        directions = changes_[change++].directions;
      for (const std::int64_t direction : directions) {
        if (direction < 0 || direction > 6)
          refuse(
              "direction " + std::to_string(direction) + " at node " + std::to_string(nodes_[i]) + " is not mechanical",
              "directions 1 ... 6 are displacements and rotations; 0 is a generalised coordinate");
        dofs.push_back({nodes_[i], static_cast<int>(direction) - 1});
      }
    }
    auto sorted = dofs;
    std::ranges::sort(sorted);
    if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end())
      refuse("degree of freedom " + to_string(*twice) + " of the element is listed twice", "each needs one row");
    if (change != changes_.size())
      refuse("the directions of *USER ELEMENT change at a node position that does not exist",
             "positions must rise from 1 to NODES");
    return dofs;
  }

  // Checks the number of values against n (n + 1) / 2, or n^2 with UNSYMM, and takes them column by column.
  void finish_matrix() {
    if (block_ != Block::matrix) return;
    const std::size_t n = dofs_.size();
    const std::size_t expected = unsymmetric_ ? n * n : n * (n + 1) / 2;
    if (values_.size() != expected)
      refuse("matrix '" + name_ + "' has " + std::to_string(values_.size()) + " entries",
             std::to_string(n) + " degrees of freedom need " + std::to_string(expected));
    const auto size = static_cast<std::int64_t>(n);
    MatrixEntries entries(source_, name_, size, size, bytes_, lines_.number());
    std::size_t next = 0;
    for (std::int64_t column = 0; column < size; ++column)
      for (std::int64_t row = 0; row < (unsymmetric_ ? size : column + 1); ++row, ++next)
        entries.add(row, column, values_[next].first, values_[next].second);
    matrices_.push_back(entries.finish(unsymmetric_ ? Storage::full : Storage::one_triangle));
    matrices_.back().dofs = dofs_;
    values_.clear();
    block_ = Block::none;
  }

  [[noreturn]] void refuse(std::string what, std::string why, std::string fix = {}) const {
    refuse_matrix(source_, lines_.number(), std::move(what), std::move(why), std::move(fix));
  }

  struct Change {
    std::int64_t position;
    std::vector<std::int64_t> directions;
  };

  LineReader lines_;
  std::size_t bytes_;
  const std::string& source_;
  Block block_ = Block::none;
  bool in_nodes_ = false, unsymmetric_ = false;
  std::size_t count_ = 0;
  std::vector<std::int64_t> nodes_;
  std::vector<Change> changes_;
  std::vector<MatrixDof> dofs_;
  std::string name_;
  std::vector<std::pair<double, int>> values_;
  std::vector<ForeignMatrix> matrices_;
  std::string others_;  ///< keywords of loads and titles
};

}  // namespace

std::vector<ForeignMatrix> parse_user_element(std::string_view text, const std::string& source) {
  return UserElementReader(text, source).read();
}

}  // namespace kalfem
