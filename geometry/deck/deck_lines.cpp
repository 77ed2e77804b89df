// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/deck/deck_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>

#include "geometry/core/packed_file.h"

namespace mv {
namespace {

constexpr std::size_t deepest_include = 16;

std::string trimmed(const std::string& text) {
  std::size_t a = 0, b = text.size();
  while (a < b && std::isspace(static_cast<unsigned char>(text[a]))) ++a;
  while (b > a && std::isspace(static_cast<unsigned char>(text[b - 1]))) --b;
  return text.substr(a, b - a);
}

std::string unquoted(std::string text) {
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
  return text;
}

/// Commas inside double quotes do not part fields.
std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (c == ',' && !is_quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  for (std::string& field : fields) field = trimmed(field);
  return fields;
}

bool is_comment(const std::string& line) { return line.starts_with("**"); }
bool is_keyword(const std::string& line) { return line.starts_with("*") && !is_comment(line); }

class Reader {
 public:
  explicit Reader(DeckLines& out) : out_(out) {}

  void read(const std::filesystem::path& file) {
    const std::filesystem::path real = std::filesystem::weakly_canonical(file);
    if (std::find(open_.begin(), open_.end(), real) != open_.end()) out_.fail(includer_, "*INCLUDE of " + file.string() + " goes round in a circle");
    if (open_.size() > deepest_include) out_.fail(includer_, "*INCLUDE is nested deeper than 16 files");
    const std::string text = read_file_unpacked(file);
    const int index = static_cast<int>(out_.files.size());
    out_.files.push_back(file);
    open_.push_back(real);
    if (text.find('\0') != std::string::npos) out_.fail({index, 1}, "the file holds null bytes; expected an Abaqus input file in plain text");
    long number = 0;
    std::string pending;  // a keyword line that ended in a comma
    DeckPlace pending_place;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      const std::string line = trimmed(text.substr(at, end - at));
      at = end + 1;
      const DeckPlace place{index, ++number};
      if (line.empty() || is_comment(line)) continue;
      if (!pending.empty()) {
        if (is_keyword(line)) out_.fail(pending_place, "the keyword line ends in a comma but is followed by another keyword");
        pending += line;
      } else if (is_keyword(line)) {
        pending = line;
        pending_place = place;
      } else {
        add_data(place, line);
        continue;
      }
      if (pending.ends_with(',')) continue;
      add_keyword(pending_place, std::exchange(pending, ""));
    }
    if (!pending.empty()) out_.fail(pending_place, "the keyword line ends in a comma at the end of the file");
    open_.pop_back();
  }

 private:
  void add_keyword(const DeckPlace& place, const std::string& line) {
    const std::vector<std::string> fields = split(line);
    DeckBlock block;
    block.keyword = deck_name(fields[0].substr(1));
    block.place = place;
    if (block.keyword.empty()) out_.fail(place, "a star without a keyword");
    for (std::size_t f = 1; f < fields.size(); ++f) {
      if (fields[f].empty()) continue;
      const std::size_t equals = fields[f].find('=');
      const std::string name = deck_name(fields[f].substr(0, equals));
      if (name.empty()) out_.fail(place, fmt::format("'{}' has no name before '='", fields[f]));
      block.options[name] = equals == std::string::npos ? "" : unquoted(trimmed(fields[f].substr(equals + 1)));
    }
    if (block.keyword != "include") {
      out_.blocks.push_back(std::move(block));
      return;
    }
    const std::string input = block.option("input");
    if (input.empty()) out_.fail(place, "*INCLUDE without INPUT=file");
    const auto file = out_.files[static_cast<std::size_t>(place.file)].parent_path() / input;
    if (!std::filesystem::exists(file)) out_.fail(place, fmt::format("*INCLUDE: {} does not exist; put it beside the deck", file.string()));
    const DeckPlace before = std::exchange(includer_, place);
    read(file);
    includer_ = before;
  }

  void add_data(const DeckPlace& place, const std::string& line) {
    if (out_.blocks.empty())
      out_.fail(place, fmt::format("'{}' stands before the first keyword; expected an Abaqus input file that starts with *HEADING, *PART or *NODE", line.substr(0, 40)));
    DeckBlock::Data data{place, split(line), false};
    if (data.fields.size() > 1 && data.fields.back().empty()) {
      data.fields.pop_back();
      data.continues = true;
    }
    out_.blocks.back().data.push_back(std::move(data));
  }

  DeckLines& out_;
  std::vector<std::filesystem::path> open_;
  DeckPlace includer_;
};

/// Text of a file with its includes in place; the reader has followed them before.
std::string flattened(const std::filesystem::path& file) {
  const std::string text = read_file_unpacked(file);
  std::string out, pending;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string raw = text.substr(at, end - at), line = trimmed(raw);
    at = end + 1;
    const bool is_include = pending.empty() && is_keyword(line) && deck_name(split(line)[0]) == "*include";
    if (!is_include && pending.empty()) {
      out += raw + "\n";
      continue;
    }
    pending += line;
    if (pending.ends_with(',')) continue;
    for (const std::string& field : split(std::exchange(pending, "")))
      if (const auto equals = field.find('='); equals != std::string::npos && deck_name(field.substr(0, equals)) == "input")
        out += flattened(file.parent_path() / unquoted(trimmed(field.substr(equals + 1)))) + "\n";
  }
  return out;
}

}  // namespace

std::string deck_name(const std::string& text) {
  std::string name;
  for (const char c : text) {
    if (std::isspace(static_cast<unsigned char>(c))) {
      if (!name.empty() && name.back() != ' ') name += ' ';
    } else {
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  if (name.ends_with(' ')) name.pop_back();
  return unquoted(name);
}

std::string DeckLines::where(const DeckPlace& place) const {
  const std::string file = files.empty() ? "deck" : files[static_cast<std::size_t>(place.file)].string();
  return fmt::format("{}: line {}: ", file, place.line);
}

void DeckLines::fail(const DeckPlace& place, const std::string& what) const { throw InputError(where(place) + what); }

DeckLines read_deck_lines(const std::filesystem::path& file) {
  DeckLines lines;
  Reader(lines).read(file);
  if (lines.blocks.empty()) throw InputError(file.string() + ": no keyword; expected an Abaqus input file (lines such as *NODE)");
  return lines;
}

std::string flattened_deck(const std::filesystem::path& file, int* files) {
  // Circles and missing files are found by the reader.
  const DeckLines lines = read_deck_lines(file);
  if (files) *files = static_cast<int>(lines.files.size());
  return flattened(file);
}

double deck_number(const DeckLines& lines, const DeckPlace& place, const std::string& field, const char* what) {
  std::string text = field;
  for (char& c : text)
    if (c == 'd' || c == 'D') c = 'e';
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  double value = 0;
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    lines.fail(place, fmt::format("'{}' is no finite number; expected {}", field, what));
  return value;
}

bool is_deck_label(const std::string& field) {
  return !field.empty() && std::all_of(field.begin(), field.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

long deck_integer(const DeckLines& lines, const DeckPlace& place, const std::string& field, const char* what) {
  long value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (field.empty() || error != std::errc() || end != field.data() + field.size())
    lines.fail(place, fmt::format("'{}' is no whole number; expected {}", field, what));
  return value;
}

}  // namespace mv
