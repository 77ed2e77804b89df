// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Abaqus input, line by line: comments dropped, keyword lines that end in a comma joined with the next one, *INCLUDE followed. Every line knows where
// it came from, so that an error names file and line.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "geometry/core/errors.h"

namespace mv {

struct DeckPlace {
  int file = 0;  // index into DeckLines::files
  long line = 0;
};

/// A keyword with its options (names in lower case with single spaces, values as written, quotes removed) and the data lines below it.
struct DeckBlock {
  struct Data {
    DeckPlace place;
    std::vector<std::string> fields;  // trimmed; the empty field after a trailing comma is dropped
    bool continues = false;           // ended in a comma
  };
  std::string keyword;                         // lower case without the star, e.g. "shell section"
  std::map<std::string, std::string> options;  // flag options map to ""
  DeckPlace place;
  std::vector<Data> data;

  bool has(const std::string& option) const { return options.contains(option); }
  /// Value of an option, or `otherwise`.
  std::string option(const std::string& name, const std::string& otherwise = "") const {
    const auto found = options.find(name);
    return found == options.end() ? otherwise : found->second;
  }
};

struct DeckLines {
  std::vector<std::filesystem::path> files;  // the deck and what it includes, in the order of reading
  std::vector<DeckBlock> blocks;

  /// "FILE: line N: "
  std::string where(const DeckPlace& place) const;
  [[noreturn]] void fail(const DeckPlace& place, const std::string& what) const;
};

/// Throws IoError for a file that cannot be read; InputError (file, line) for a file with null bytes or no keyword, data before the first keyword,
/// an include that names itself or lies deeper than 16, an option without a name.
DeckLines read_deck_lines(const std::filesystem::path& file);

/// The deck with every *INCLUDE replaced by the text of its file; `files` receives how many files that are. Throws as read_deck_lines().
std::string flattened_deck(const std::filesystem::path& file, int* files = nullptr);

/// Lower case, blanks trimmed and squeezed.
std::string deck_name(const std::string& text);

/// Numbers of one field; Fortran exponents (1.0D-3) are understood. Throws InputError naming place, field and what was expected.
double deck_number(const DeckLines& lines, const DeckPlace& place, const std::string& field, const char* what);
long deck_integer(const DeckLines& lines, const DeckPlace& place, const std::string& field, const char* what);
/// Whether a field is a whole number (a label) and not a name.
bool is_deck_label(const std::string& field);

}  // namespace mv
