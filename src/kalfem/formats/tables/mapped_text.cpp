// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/mapped_text.hpp"

#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {

MappedText::MappedText(const std::filesystem::path& path) : file_(path), view_(file_.bytes()) {
  require_short_lines(view_, path.string());
  if (view_.starts_with(byte_order_mark)) view_.remove_prefix(byte_order_mark.size());
  if (auto converted = utf16_as_utf8(view_)) {
    converted_ = *std::move(converted);
    view_ = converted_;
  }
}

}  // namespace kalfem
