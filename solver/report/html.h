// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "solver/output/summary.h"

namespace mv::html {

/// Text with & < > " replaced, fit for content and attributes.
std::string escape(std::string_view text);

/// Significant digits for reading at a glance, and for tables.
inline constexpr int glance = 3, exact = 6;

/// Whole numbers and what stands before the point in full, else `digits` significant digits; "–" for what is not finite.
std::string number(double value, int digits = glance);

/// Number, text, yes/no, or a list of them; "–" for null.
std::string value(const Json& json, int digits = glance);

/// Table of rows of cells that are HTML already; the first row is the head when `has_head`.
std::string table(const std::vector<std::vector<std::string>>& rows, bool has_head);

/// Leaves of nested JSON as (dotted name, leaf) in file order; lists of scalars are one leaf.
std::vector<std::pair<std::string, Json>> flatten(const Json& json);

/// Names and values of all leaves.
std::string table_of_leaves(const Json& json);

/// Tables for what a gate file holds: each list of objects becomes one table with a mark for "passed", the other leaves follow.
std::string tables_of_gates(const Json& json);

std::string details(const std::string& title, const std::string& content);
std::string missing(const std::string& what);

/// JSON that may stand inside a <script> element.
std::string script_json(const Json& json);

/// Marks that do not rest on colour alone.
std::string pass_mark(bool is_passed);

}  // namespace mv::html
