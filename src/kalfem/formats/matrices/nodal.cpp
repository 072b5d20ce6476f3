// "node, direction, node, direction, value" as *MATRIX INPUT of Abaqus and the substructures of CalculiX have it, alone
// in a file (*MATRIX OUTPUT) or below keyword lines that name the matrix.

#include <algorithm>

#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/readers.hpp"

namespace kalfem {
namespace {

/// Value of a parameter of a keyword line in lower case, "" where it has none of that name.
std::string parameter(std::string_view line, const std::string& name) {
  std::string text = lower_case(line);
  std::erase_if(text, [](char c) { return c == ' ' || c == '\t'; });
  const std::size_t at = text.find("," + name + "=");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + name.size() + 2;
  return text.substr(begin, text.find(',', begin) - begin);
}

class NodalReader {
public:
  NodalReader(std::string_view text, const std::string& source) : lines_(text), bytes_(text.size()), source_(source) {}

  std::vector<ForeignMatrix> read() {
    while (const auto line = lines_.next()) {
      if (line->starts_with("**")) continue;
      if (line->starts_with('*')) {
        begin(*line);
        continue;
      }
      const auto words = number_words(*line);
      if (words.empty() || words[0].starts_with('#') || words[0].starts_with('%')) continue;
      add(words);
    }
    finish();
    if (matrices_.empty())
      refuse("the file holds no entry of a matrix", "node, direction, node, direction and value are needed");
    return std::move(matrices_);
  }

private:
  void begin(std::string_view keyword) {
    finish();
    name_ = parameter(keyword, "name");
    if (name_.empty()) name_ = parameter(keyword, "type");
    if (name_.empty()) name_ = parameter(keyword, "matrix");
    unsymmetric_ = parameter(keyword, "type") == "unsymmetric";
    if (unsymmetric_ && name_ == "unsymmetric") name_.clear();
    const std::string scale = parameter(keyword, "scalefactor");
    const auto factor = scale.empty() ? std::optional<double>(1.0) : fortran_number(scale);
    if (!factor)
      refuse("the scale factor '" + scale.substr(0, 40) + "' is no number", "every entry is multiplied by it");
    factor_ = *factor;
    if (!parameter(keyword, "input").empty())
      refuse("the entries stand in another file", "INPUT= names it", "read that file");
  }

  void add(const std::vector<std::string_view>& words) {
    if (words.size() != 5)
      refuse("the line holds " + std::to_string(words.size()) + " numbers",
             "an entry is node, direction, node, direction and value");
    const MatrixDof row = dof(words[0], words[1]), column = dof(words[2], words[3]);
    const auto value = fortran_number(words[4]);
    if (!value) refuse("'" + std::string(words[4].substr(0, 40)) + "' is no number", "a value is needed");
    if (!entries_) entries_.emplace(source_, name_.empty() ? name_from(source_) : name_);
    entries_->add(row, column, factor_ * *value, lines_.number());
  }

  [[nodiscard]] MatrixDof dof(std::string_view node, std::string_view direction) const {
    const auto number = whole_number(node), axis = whole_number(direction);
    if (!number || !axis || *axis < 0 || *axis > 6)
      refuse("'" + std::string(node.substr(0, 40)) + ", " + std::string(direction.substr(0, 40)) +
                 "' is no degree of freedom",
             "a node's number and a direction 1 ... 6 are needed, or 0 for a generalised coordinate");
    if (*number < 0)
      refuse("the matrix has the internal node " + std::to_string(*number),
             "it holds multipliers of constraints and is not positive definite",
             "write it without the constraints, or condense it to retained nodes in the other code");
    // Node 0 has generalised coordinates too: the direction counts them.
    if (*number == 0) return {*axis, -1};
    return {*number, static_cast<int>(*axis) - 1};
  }

  void finish() {
    if (entries_)
      matrices_.push_back(entries_->finish(unsymmetric_ ? Storage::full : Storage::triangle_or_full, bytes_));
    entries_.reset();
  }

  [[noreturn]] void refuse(std::string what, std::string why, std::string fix = {}) const {
    refuse_matrix(source_, lines_.number(), std::move(what), std::move(why), std::move(fix));
  }

  LineReader lines_;
  std::size_t bytes_;
  const std::string& source_;
  std::vector<ForeignMatrix> matrices_;
  std::optional<NodalEntries> entries_;
  std::string name_;
  bool unsymmetric_ = false;
  double factor_ = 1.0;
};

}  // namespace

std::vector<ForeignMatrix> parse_nodal(std::string_view text, const std::string& source) {
  return NodalReader(text, source).read();
}

}  // namespace kalfem
