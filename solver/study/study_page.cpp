// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/study_page.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <thread>

#include "geometry/core/version.h"
#include "solver/report/html.h"
#include "solver/report/page.h"

namespace mv {

std::string machine_name() {
  std::ifstream info("/proc/cpuinfo");
  std::string name = "unknown processor";
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name") && line.find(':') != std::string::npos) {
      name = line.substr(line.find(':') + 2);
      break;
    }
  return fmt::format("{}, {} threads", name, std::thread::hardware_concurrency());
}

std::string seconds_text(double s) {
  if (!std::isfinite(s)) return "–";
  if (s >= 600) return html::number(s / 60) + " min";
  if (s >= 0.5) return html::number(s) + " s";
  if (s >= 5e-4) return html::number(1e3 * s) + " ms";
  return html::number(1e6 * s) + " µs";
}

std::string study_page(const std::string& title, const std::string& lead, const std::vector<PageSection>& sections, const std::string& command) {
  std::string page = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
                     html::escape(title) + "</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>\n" + std::string(assets::style_css) +
                     "svg text { font-family: inherit; } .panels { display: flex; flex-wrap: wrap; gap: 14px 10px; } svg { max-width: 100%; height: auto; }\n"
                     "th { vertical-align: bottom; } td { white-space: nowrap; } td.wrap { white-space: normal; min-width: 24ch; } .dense th, .dense td { padding-right: 9px; font-size: 12.5px; }\n"
                     "</style>\n</head>\n<body>\n<main>\n<header><h1>" +
                     html::escape(title) + "</h1></header>\n<p>" + lead + "</p>\n<nav class=\"screen-only\">";
  for (const PageSection& s : sections) page += "<a href=\"#" + s.id + "\">" + html::escape(s.title) + "</a>";
  page += "</nav>\n";
  for (const PageSection& s : sections) page += "<h2 id=\"" + s.id + "\">" + html::escape(s.title) + "</h2>\n" + s.html;
  page += "<footer>Made by <code>" + html::escape(command) + "</code>, mvsolve " + html::escape(version()) + " (" + html::escape(git_revision()) + "), on " +
          html::escape(machine_name()) + ". Nothing on this page is loaded from elsewhere.</footer>\n</main>\n</body>\n</html>\n";
  return page;
}

}  // namespace mv
