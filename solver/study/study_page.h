// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace mv {

struct PageSection {
  std::string id, title;
  std::string html;  // content, escaped where it is text
};

/// A self-contained page in the style of report.html, without scripts: title, a lead paragraph (HTML), links to the sections, the sections, and a footer
/// that names command, version, revision and machine.
std::string study_page(const std::string& title, const std::string& lead, const std::vector<PageSection>& sections, const std::string& command);

/// Processor's name and number of cores, for pages and JSON.
std::string machine_name();

/// Table cell text for a time: "0.12 s", "3.4 ms", "12 min".
std::string seconds_text(double seconds);

}  // namespace mv
