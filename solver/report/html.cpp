// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/html.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace mv::html {

namespace {

std::string spaced(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

bool is_list_of_objects(const Json& json) { return json.is_array() && !json.empty() && json.front().is_object(); }

/// 1 passed, 0 failed, -1 not said.
int verdict_of(const Json& gate) {
  if (const auto at = gate.find("passed"); at != gate.end() && at->is_boolean()) return at->get<bool>() ? 1 : 0;
  if (const auto at = gate.find("verdict"); at != gate.end() && at->is_string())
    return *at == "pass" ? 1 : *at == "fail" ? 0 : -1;
  return -1;
}

/// mvprep's gates {name, verdict, value, limit, relation, unit, worst_element, message} in four columns (the message names the
/// element); further keys get columns of their own.
std::string gate_table(const Json& gates) {
  static const std::vector<std::string> known{"name",     "verdict", "passed",        "value",  "limit",
                                              "relation", "unit",    "worst_element", "message"};
  std::vector<std::string> more;
  for (const Json& gate : gates)
    for (const auto& [key, content] : gate.items())
      if (std::find(known.begin(), known.end(), key) == known.end() && std::find(more.begin(), more.end(), key) == more.end()) {
        const bool is_blank = std::all_of(gates.begin(), gates.end(), [&key = key](const Json& g) {
          return !g.contains(key) || g[key].is_null() || g[key] == -1;
        });
        if (!is_blank) more.push_back(key);
      }
  const auto cell = [](const Json& gate, const char* key) { return gate.contains(key) ? value(gate[key], 4) : std::string(); };
  std::vector<std::vector<std::string>> rows{{"", "gate", "value", "required"}};
  for (const std::string& key : more) rows[0].push_back(escape(spaced(key)));
  rows[0].push_back("what was found");
  for (const Json& gate : gates) {
    const int verdict = verdict_of(gate);
    const std::string unit = cell(gate, "unit");
    std::string relation = cell(gate, "relation");
    if (relation == "&gt;=") relation = "≥";
    if (relation == "&lt;=") relation = "≤";
    if (relation == "==") relation = "=";
    rows.push_back({verdict < 0 ? "" : pass_mark(verdict == 1), "<code>" + cell(gate, "name") + "</code>",
                    cell(gate, "value") + (unit.empty() || unit == "1" ? "" : " " + unit),
                    relation + (relation.empty() ? "" : " ") + cell(gate, "limit")});
    for (const std::string& key : more) rows.back().push_back(gate.contains(key) && gate[key] != -1 ? value(gate[key]) : "");
    rows.back().push_back(cell(gate, "message"));
  }
  return table(rows, true);
}

void collect(const Json& json, const std::string& name, std::vector<std::pair<std::string, Json>>& out) {
  const bool is_branch = json.is_object() || is_list_of_objects(json);
  if (!is_branch) {
    out.emplace_back(name, json);
    return;
  }
  int index = 0;
  for (const auto& [key, content] : json.items())
    collect(content, name.empty() ? key : name + "." + (json.is_array() ? std::to_string(index++) : key), out);
}

}  // namespace

std::string escape(std::string_view text) {
  std::string out;
  for (char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string number(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  if (value == 0) return "0";
  const double size = std::abs(value);
  const bool is_whole = value == std::round(value) || size >= std::pow(10.0, digits - 1);
  char text[48];
  if (is_whole && size < 1e9)
    std::snprintf(text, sizeof text, "%.0f", value);
  else
    std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

std::string value(const Json& json, int digits) {
  if (json.is_null()) return "–";
  if (json.is_boolean()) return json.get<bool>() ? "yes" : "no";
  if (json.is_number()) return number(json.get<double>(), digits);
  if (json.is_string()) {
    std::string text = json.get<std::string>(), out;
    while (text.ends_with('\n')) text.pop_back();
    for (char c : text) out += c == '\n' ? "<br>" : escape(std::string_view(&c, 1));
    return out;
  }
  if (json.is_array() && !is_list_of_objects(json)) {
    std::string out;
    for (const Json& item : json) out += (out.empty() ? "" : ", ") + value(item, digits);
    return out.empty() ? "none" : out;
  }
  return "<code>" + escape(json.dump()) + "</code>";
}

std::string table(const std::vector<std::vector<std::string>>& rows, bool has_head) {
  std::string out = "<div class=\"scroll\"><table>\n";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const char* tag = r == 0 && has_head ? "th" : "td";
    out += "<tr>";
    for (const std::string& cell : rows[r]) out += std::string("<") + tag + ">" + cell + "</" + tag + ">";
    out += "</tr>\n";
  }
  return out + "</table></div>\n";
}

std::vector<std::pair<std::string, Json>> flatten(const Json& json) {
  std::vector<std::pair<std::string, Json>> out;
  if (!json.is_null()) collect(json, "", out);
  return out;
}

std::string table_of_leaves(const Json& json) {
  std::string out = "<div class=\"scroll\"><table>\n";
  for (const auto& [name, leaf] : flatten(json)) {
    const bool is_hash = leaf.is_string() && leaf.get<std::string>().size() >= 40;
    out += "<tr><td>" + escape(name) + "</td><td" +
           (is_hash ? " class=\"hash\"><code>" + value(leaf) + "</code>" : ">" + value(leaf, exact)) + "</td></tr>\n";
  }
  return out + "</table></div>\n";
}

std::string tables_of_gates(const Json& json) {
  std::string out;
  if (const auto all = json.find("passed"); all != json.end() && all->is_boolean())
    out += "<p>" + pass_mark(all->get<bool>()) + " in all</p>\n";
  Json rest = Json::object();
  for (const auto& [key, content] : json.items()) {
    if (is_list_of_objects(content))
      out += (key == "gates" ? "" : "<h3>" + escape(spaced(key)) + "</h3>\n") + gate_table(content);
    else if (key != "passed")
      rest[key] = content;
  }
  const std::size_t leaves = flatten(rest).size();
  if (leaves == 0) return out;
  return out + (leaves > 14 ? details("Further numbers (" + std::to_string(leaves) + ")", table_of_leaves(rest))
                            : table_of_leaves(rest));
}

std::string details(const std::string& title, const std::string& content) {
  return "<details><summary>" + escape(title) + "</summary>\n" + content + "</details>\n";
}

std::string missing(const std::string& what) { return "<p class=\"missing\">" + escape(what) + "</p>\n"; }

std::string script_json(const Json& json) {
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace), out;
  out.reserve(text.size());
  for (char c : text) {
    if (c == '<')
      out += "\\u003c";  // neither </script> nor <!-- can appear
    else
      out += c;
  }
  return out;
}

std::string pass_mark(bool is_passed) {
  return is_passed ? "<span class=\"pass\"><span class=\"mark\">✓</span>passed</span>"
                   : "<span class=\"fail\"><span class=\"mark\">✗</span>failed</span>";
}

}  // namespace mv::html
