// SPDX-License-Identifier: Apache-2.0
#include "kalfem/page/live_page.hpp"

#include "kalfem/base/version.hpp"
#include "kalfem/page/embedded_assets.hpp"

namespace kalfem {
namespace {

/// The document may use itself, and read the messages.
constexpr const char* content_policy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'";

}  // namespace

std::string live_page() {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<meta name=\"color-scheme\" content=\"light dark\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"" +
         std::string(content_policy) +
         "\">\n<title>kalfem watch</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>" +
         std::string(assets::page_style()) +
         "</style>\n</head>\n<body>\n<div id=\"live\"></div>\n"
         "<noscript><p class=\"note\">This page needs JavaScript; /metrics and /health do not.</p></noscript>\n"
         "<footer>Told by kalfem " +
         std::string(version) + "</footer>\n<script>" + std::string(assets::live_script()) +
         "</script>\n</body>\n</html>\n";
}

}  // namespace kalfem
