// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/version.h"

#include <vtkVersion.h>

#include <Eigen/Core>

#include "geometry/core/version_data.h"

namespace mv {

std::string version() { return MV_VERSION; }

std::string git_revision() { return MV_REVISION; }

std::string library_versions() {
  std::string text;
#ifdef __VERSION__
  text += std::string("compiler ") + __VERSION__ + "\n";
#endif
  text += "Eigen " + std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
          std::to_string(EIGEN_MINOR_VERSION) + "\n";
  text += std::string("VTK ") + vtkVersion::GetVTKVersion() + "\n";
  return text;
}

}  // namespace mv
