#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Configures and builds mvsolve with the packages of mvprep made unfindable, and proves that the program links none of them.
set -euo pipefail
source_dir=$1
build_dir=$2
generator=()
command -v ninja >/dev/null && generator=(-G Ninja)
disabled=()
for package in CGAL gmsh Gmsh TetGen OpenCV NIFTI ITK; do disabled+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=TRUE"); done
cmake -S "$source_dir" -B "$build_dir" "${generator[@]}" -DCMAKE_BUILD_TYPE=Release -DMV_BUILD_MVPREP=OFF -DMV_BUILD_TESTS=OFF "${disabled[@]}"
if grep -Ei '^(CGAL|gmsh|OpenCV|NIFTI|TetGen)[A-Za-z_]*:(PATH|FILEPATH)=/' "$build_dir/CMakeCache.txt"; then
  echo "the solver-only configuration looked for packages of mvprep" >&2
  exit 1
fi
cmake --build "$build_dir" --target mvsolve
if ldd "$build_dir/bin/mvsolve" | grep -Ei 'cgal|gmsh|opencv|nifti|libtet'; then
  echo "mvsolve links packages of mvprep" >&2
  exit 1
fi
"$build_dir/bin/mvsolve" --version
