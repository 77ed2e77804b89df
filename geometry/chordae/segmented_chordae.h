// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// A segmented network of chordae hung on a valve: trees stay trees, with their branch points.
//
//   roots   points said to be roots, else loose ends near a muscle, else a piece's point nearest to a muscle. Each goes to the
//           muscle whose tip or head is nearest and stays where it was segmented (the muscle carries it along).
//   ends    points said to be on the leaflet, else the other loose ends. Each is projected on the leaflet and holds it by an influence
//           sphere (insertion.h) of radius R where the chorda reaches the leaflet without a branch, R/2 otherwise (papers/s0, 2.1).
//   kind    by where the end lies, h the leaflet's height there: within `border_band` of the border primary; nearer to the annulus than
//           basal_share h basal; on the anterior leaflet with an area of at least strut_area strut; else secondary. A segment above
//           a branch takes the kind of most of its ends. A kind named in the file stays.
//   length  rest length = segmented length x slack, or what the file says. A run of segments without a branch becomes one segment
//           of the same length along the run: curved runs are slack until straight.

#include <optional>
#include <string>
#include <vector>

#include "geometry/chordae/chordae_file.h"
#include "geometry/core/case.h"

namespace mv {

enum class NetworkDefects { refuse, drop };

struct SegmentedOptions {
  double slack = 1.0;
  std::optional<double> radius;        // mm, influence radius R; default influence_radius()
  double area_primary = 0.4;           // mm2, where the file says nothing
  double area_secondary = 0.8;         // mm2
  double end_reach = 3.0;              // mm: largest distance of a leaflet end from the leaflet's mid-surface
  double root_reach = 15.0;            // mm: largest distance of a root from its muscle's tip or nearest head
  double gap = 1.0;                    // mm: loose ends of one piece nearer than this to another piece are joined to it
  double border_band = 2.5;            // mm
  double basal_share = 0.3;
  double strut_area = 0.6;             // mm2
  bool merge_runs = true;
  NetworkDefects defects = NetworkDefects::refuse;
  bool refuse_loops = false;           // loops (anastomoses) carry load like any chorda; true: an error
};

struct SegmentedReport {
  int trees = 0, roots = 0, ends = 0, branch_points = 0, loops = 0;
  int joined_gaps = 0;                 // loose ends joined to a neighbouring piece
  int dropped_pieces = 0, dropped_segments = 0;
  double end_moved_mean = 0, end_moved_max = 0;     // mm, by projection
  double root_distance_max = 0;                     // mm, root to its muscle
  double length_total = 0;                          // mm, segmented
  int radius_enlarged = 0;             // spheres made larger to reach both faces
  int crossings = 0;                   // segments that pass through a leaflet away from their end
  std::vector<std::string> notes;      // one sentence each, with places
};

/// `papillary.tips`: one per muscle (any number >= 1). `heads`: more points of muscles (mm), each belonging to the nearest tip.
/// Throws InputError naming the place (mm) and what to do: a piece without root or without leaflet end, a loose end that is near
/// neither (NetworkDefects::refuse), a loop when refused, coordinates that cannot belong to this valve (wrong unit or space).
Chordae attach_chordae(const LeafletMesh& mesh, const Papillary& papillary, const std::vector<Vec3>& heads, const RawChordae& raw,
                       const SegmentedOptions& options, SegmentedReport* report = nullptr);

}  // namespace mv
