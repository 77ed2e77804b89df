// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace mv {

/// Project version, e.g. "0.1.0".
std::string version();

/// Git revision the binaries were built from ("<hash>" or "<hash>-dirty"), "unknown" outside a repository.
std::string git_revision();

/// Versions of the libraries that shape the files: compiler, Eigen, VTK, as "name version" lines.
std::string library_versions();

}  // namespace mv
