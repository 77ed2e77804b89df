// SPDX-License-Identifier: BSD-3-Clause
// The schema: one row per key. To add a key, add a row; nothing else is needed.
//
// type:    flag | integer | number | a dimension (length, area, volume, time, pressure, density, viscosity, force, velocity,
// angle,
//          stiffness, flow) | text | path | choice a|b|c
//          "type[]" or "type[3]" is a list; a trailing "?" lets the value be "auto"
// default: as in the file, without the quotes; "auto" where the type has "?"
// range:   "lowest .. highest", either side may be missing; it also names the unit in which the value is written when the default
// is auto
#include <cstring>
#include <limits>
#include <stdexcept>

#include "geometry/core/config.h"
#include "geometry/core/config_values.h"

namespace mv {
namespace {

struct Row {
  const char* name;
  const char* type;
  const char* default_text;
  const char* range;
  const char* doc;
};

const Row rows[] = {
    // clang-format off
    {"case.name", "text", "generic", "", "name shown in the report"},

    {"source.kind", "choice generic|labels|curves|surface|deck", "generic", "", "where the leaflets come from: the generic valve (on an ellipse or a measured annulus), a label map, slices or curves, a surface, an Abaqus deck"},

    {"generic.axis_major", "length", "38 mm", "5 mm .. 200 mm", "long diameter of the elliptic annulus, between the commissures (x)"},
    {"generic.axis_minor", "length", "30 mm", "5 mm .. 200 mm", "short diameter of the elliptic annulus, anterior to posterior (y)"},
    {"generic.saddle_height", "length", "0 mm", "0 mm .. 50 mm", "height of the saddle from its lowest to its highest point"},
    {"generic.strip_height", "length", "6 mm", "0 mm .. 50 mm", "strip along the annulus below which the semicircles start; the height at the commissures"},
    {"generic.anterior_radius", "length", "18 mm", "1 mm .. 100 mm", "radius of the anterior semicircle on the flat pattern"},
    {"generic.anterior_height", "number", "0.9", "0.05 .. 3", "height of the anterior semicircle over its radius"},
    {"generic.posterior_height", "number", "0.75", "0.05 .. 3", "height of the posterior semicircles over their radius"},
    {"generic.posterior_scallops", "integer", "3", "1 .. 9", "number of posterior semicircles"},
    {"generic.inward_slope", "number", "0.35", "0 .. 2", "slope of the cone: inward run over the drop along the leaflet"},
    {"generic.annulus", "path", "", "", "CSV of a real annulus (columns x_mm,y_mm,z_mm, ordered, closed); empty for the ellipse"},
    {"generic.papillary", "path", "", "", "CSV of papillary points (columns x_mm,y_mm,z_mm); empty for the two tips below"},
    {"generic.proportional", "flag", "true", "", "scale all lengths of the pattern by the perimeter of the real annulus over the ellipse's"},
    {"generic.anterior_direction", "number[3]?", "auto", "", "direction (world frame) from the annulus centre towards the anterior leaflet of a real annulus"},
    {"generic.notch_radius", "length", "1 mm", "0 mm .. 10 mm", "fillet in the notches between neighbouring semicircles"},
    {"generic.smoothing_harmonics", "integer", "12", "0 .. 100", "Fourier harmonics kept of a real annulus; 0 takes it as it is"},
    {"generic.papillary_tips_anterolateral", "length[3]", "[-10 mm, -2 mm, -32 mm]", "", "anterolateral tip in the valve's frame: x along the commissures, y anterior, z towards the atrium, origin in the annulus; scaled with the pattern"},
    {"generic.papillary_tips_posteromedial", "length[3]", "[10 mm, -2 mm, -32 mm]", "", "posteromedial tip in the valve's frame"},

    {"labels.file", "path", "", "", "label map, NIfTI-1 or NIfTI-2 (.nii, .nii.gz), one whole number per voxel"},
    {"labels.preset", "choice mvseg2023|slicerheart|visible_human|own", "mvseg2023", "", "which label is what: mvseg2023 (1 posterior, 2 anterior), slicerheart (1 anterior, 2 posterior), visible_human (as mvseg2023, 3 and 4 anterolateral and posteromedial papillary muscle, 5 atrium, 6 ventricle), own (the keys below only)"},
    {"labels.posterior", "integer[]", "[]", "", "labels of the posterior leaflet, all of its scallops; here and below: empty keeps the preset's"},
    {"labels.anterior", "integer[]", "[]", "", "labels of the anterior leaflet"},
    {"labels.papillary_anterolateral", "integer[]", "[]", "", "labels of the anterolateral papillary muscle"},
    {"labels.papillary_posteromedial", "integer[]", "[]", "", "labels of the posteromedial papillary muscle"},
    {"labels.papillary", "integer[]", "[]", "", "labels of both papillary muscles, or of muscles not told apart"},
    {"labels.atrium", "integer[]", "[]", "", "labels of the left atrium (wall or cavity); with the ventricle's they give the annulus"},
    {"labels.ventricle", "integer[]", "[]", "", "labels of the left ventricle (wall or cavity)"},
    {"labels.aorta", "integer[]", "[]", "", "labels of the aortic root or valve: tells the anterior side"},
    {"labels.transform", "choice auto|sform|qform|spacing", "auto", "", "which of the file's transforms places the image; auto: the one there is, or both when they agree; spacing: voxel sizes only, axes taken as right, anterior, superior"},
    {"labels.unit", "choice auto|mm|m|um", "auto", "", "unit of length of the file; auto: what its header says"},
    {"labels.smoothing", "number", "3", "0 .. 20", "stair steps shorter than 2 pi times so many voxels vanish from the leaflets' surface, within what the voxels allow"},
    {"labels.hole_radius", "number", "2.5", "0 .. 3", "holes through the leaflets up to about twice so many voxels wide, as thin spots leave, are filled; 0 keeps them"},
    {"labels.island_share", "number", "0.05", "0 .. 1", "separate groups of leaflet voxels below this share of the largest are removed"},

    {"patient.annulus", "path", "", "", "CSV of the annulus (columns x_mm,y_mm,z_mm, ordered, closed), where the source does not find it or finds it wrongly"},
    {"patient.papillary", "path", "", "", "CSV of papillary points (columns x_mm,y_mm,z_mm), where the source holds none; without any, the generic tips are placed by the annulus"},
    {"patient.commissures", "path", "", "", "CSV of the two commissures (columns x_mm,y_mm,z_mm); empty: from the leaflets' borders or the outline"},
    {"patient.anterior_point", "length[3]?", "auto", "-10000 mm .. 10000 mm", "a point on the anterior side (world frame), e.g. the centre of the aortic valve; auto: from the source, the papillary tips, the leaflets' shape"},
    {"patient.ventricle_direction", "number[3]?", "auto", "", "direction (world frame) from atrium to ventricle; auto: from the source, the papillary tips, the side on which the leaflets hang"},
    {"patient.annulus_harmonics", "integer", "12", "0 .. 100", "Fourier harmonics kept of the annulus; 0 takes it as it is"},
    {"patient.smoothing", "length", "4 mm", "0 mm .. 30 mm", "wavelength that the leaflets keep by half: shorter ones (voxel stairs, noise) vanish, longer ones stay"},
    {"patient.commissure_gap", "length", "5 mm", "0 mm .. 30 mm", "separate leaflets whose annulus ends are no further apart are joined at the commissure"},
    {"patient.thickness_min", "length", "0.3 mm", "0.05 mm .. 10 mm", "measured thickness is kept above this"},
    {"patient.thickness_max", "length", "4 mm", "0.05 mm .. 20 mm", "measured thickness is kept below this"},

    {"curves.slices", "path", "", "", "segmented slices: a NIfTI stack (.nii, .nii.gz) or a folder of PNG files, optionally with slices.csv; what the labels mean: labels.preset and labels.*"},
    {"curves.files", "path[]", "[]", "", "curves drawn in another program, one or several files: .csv (leaflet,curve,x_mm,y_mm,z_mm), .vtp (polylines), .mrk.json (3D Slicer)"},
    {"curves.mask", "choice labels|binary", "labels", "", "labels: pixel values name leaflets, walls, muscles; binary: any value but 0 is leaflet"},
    {"curves.slice_axis", "choice auto|i|j|k", "auto", "", "axis of the NIfTI image along which it is a stack of slices; auto: the one with the longest voxels, else k"},
    {"curves.pixel_spacing", "length[2]?", "auto", "0.01 mm .. 20 mm", "PNG: pixel size along a row and down a column, unless slices.csv says"},
    {"curves.slice_spacing", "length?", "auto", "0.01 mm .. 50 mm", "PNG: distance of neighbouring slices, unless slices.csv places them"},
    {"curves.position", "length[3]", "[0 mm, 0 mm, 0 mm]", "", "PNG: centre of the first slice's top left pixel"},
    {"curves.row_direction", "number[3]", "[1, 0, 0]", "", "PNG: direction along a row; the slices follow each other along row x column"},
    {"curves.column_direction", "number[3]", "[0, 1, 0]", "", "PNG: direction down a column"},
    {"curves.space", "choice RAS|LPS", "RAS", "", "coordinates of PNG placement, of CSV, and of VTP files that do not say"},
    {"curves.bridge_gap", "length", "2.5 mm", "0 mm .. 20 mm", "slices: gaps in a leaflet up to this are closed"},
    {"curves.island_area", "area", "2 mm2", "0 mm2 .. 1000 mm2", "slices: separate pieces below this are no leaflet"},
    {"curves.smoothing", "choice gcv|discrepancy", "gcv", "", "how smooth the B-spline surface is: by generalised cross-validation, or as smooth as curves.noise allows"},
    {"curves.noise", "length?", "auto", "0.001 mm .. 10 mm", "accuracy of curve points, for discrepancy; auto: half a pixel"},
    {"curves.knot_spacing", "length", "4 mm", "1 mm .. 30 mm", "distance of the B-spline's knots"},
    {"curves.thickness", "choice measured|uniform", "measured", "", "measured: where the slices (or the column thickness_mm) show it; uniform: mesh.thickness"},

    {"surface.file", "path", "", "", "surface of the leaflets: .stl, .obj, .ply, .vtp or .vtk"},
    {"surface.unit", "choice auto|mm|cm|m|um", "auto", "", "unit of length of the files; auto: what a VTK file records, else mm"},
    {"surface.space", "choice RAS|LPS", "RAS", "", "coordinates of the files"},
    {"surface.kind", "choice auto|thick|double_wall|mid", "auto", "", "what the surface is: thick leaflets closed all round, both faces open along the annulus, or the mid-surface; auto: from its rims"},
    {"surface.papillary", "path[]", "[]", "", "papillary muscles: closed surfaces, one or several files (the tip is the end towards the leaflets), or CSV of tips (columns x_mm,y_mm,z_mm; always mm)"},

    {"deck.file", "path", "", "", "Abaqus input file (.inp)"},
    {"deck.units", "choice mm-tonne-s|mm-g-s|m-kg-s", "mm-tonne-s", "", "consistent units of the deck: mm and MPa, mm and Pa, m and Pa"},
    {"deck.leaflets", "text[]", "[]", "", "element sets of the leaflets as NAME=SET, NAME anterior, posterior or septal, e.g. [\"anterior=AML\"]; empty: sets of shells whose names hold the leaflet's name"},
    {"deck.duration", "time", "100 ms", "0.1 ms .. 1000 s", "time in the case for the deck's step: its amplitudes are stretched to this"},
    {"deck.user_law", "choice none|isotropic_exponential", "none", "", "what a user-defined material of the deck computes"},
    {"deck.user_properties", "text[]", "[]", "", "what its constants are, in order: iso_c0, iso_c1, iso_c2, or - for one that is not used, e.g. [\"iso_c0\", \"-\", \"iso_c1\", \"iso_c2\"]"},
    {"deck.merge_chains", "flag", "true", "", "a run of trusses without a branch becomes one chorda of the same length"},
    {"deck.remesh", "flag", "false", "", "new even triangles of mesh.spacing instead of the deck's own nodes (two-leaflet valves)"},

    {"mesh.spacing", "length", "0.5 mm", "0.05 mm .. 10 mm", "distance of neighbouring solid points; half the fluid spacing or less"},
    {"mesh.layers", "integer", "2", "1 .. 8", "layers of tetrahedra through the thickness"},
    {"mesh.path", "choice mid|thick", "mid", "", "what is filled with tetrahedra: the mid-surface with its thickness, in layers; or the thick leaflets as the surface or label map has them, faces included, by TetGen and by gmsh, of which the better is kept (no layers)"},
    {"mesh.order", "integer", "1", "1 .. 2", "1 linear tetrahedra, 2 quadratic (C3D10)"},
    {"mesh.thickness", "length", "1 mm", "0.05 mm .. 10 mm", "leaflet thickness where none is measured"},

    {"chordae.model", "choice generic|density|file|deck|none", "generic", "", "chordae: fixed numbers (generic), by density and branching (density), a segmented network (file), the trusses and beams of the deck (deck), none"},
    {"chordae.primary", "integer", "14", "0 .. 200", "primary chordae, to the free border"},
    {"chordae.secondary", "integer", "8", "0 .. 200", "secondary chordae, to the ventricular face inside the border"},
    {"chordae.slack", "number", "1.0", "0.5 .. 2", "rest length over the distance between the ends"},
    {"chordae.stiffness", "pressure", "20 MPa", "1 kPa ..", "Young's modulus in tension"},
    {"chordae.area_primary", "area", "0.4 mm2", "0.001 mm2 .. 100 mm2", "cross-section of a primary chorda"},
    {"chordae.area_secondary", "area", "0.8 mm2", "0.001 mm2 .. 100 mm2", "cross-section of a secondary chorda"},
    {"chordae.influence_radius", "length?", "auto", "0.05 mm .. 50 mm", "radius R of the influence sphere at an unbranched leaflet end (R/2 at branched ones)"},
    {"chordae.law", "choice linear|ogden", "linear", "", "tension over stretch: linear (chordae.stiffness), or Ogden (chordae.LEAFLET.ogden_*) by the leaflet that the chorda holds"},
    {"chordae.density", "density", "1100 kg/m3", "1 kg/m3 .. 20000 kg/m3", "density of the chordae"},
    {"chordae.bifurcated", "flag", "false", "", "primary chordae end in two branches with influence radius R/2"},
    {"chordae.coaptation_depth", "length", "5 mm", "0 mm .. 50 mm", "depth below the annulus at which the closed leaflets meet; rest lengths follow from it; scaled with the pattern"},
    {"chordae.removed", "integer[]", "[]", "0 ..", "indices of chordae to leave out, as a rupture"},

    {"chordae.heads", "path", "", "", "CSV of points of the papillary muscles (x_mm,y_mm,z_mm) from which chordae spring, each belonging to the nearest tip; empty: the tips alone (density, file)"},

    {"chordae.file", "path", "", "", "file: segmented network (.vtp, .vtk, .swc, .csv)"},
    {"chordae.file_unit", "choice mm|cm|m|um", "mm", "", "file: unit of its lengths"},
    {"chordae.file_space", "choice ras|lps", "ras", "", "file: axes of its coordinates"},
    {"chordae.file_defects", "choice refuse|drop", "refuse", "", "file: pieces without root or leaflet end and loose ends are an error, or left out with a warning"},
    {"chordae.file_loops", "choice keep|refuse", "keep", "", "file: loops between chordae carry load like any other, or are an error"},
    {"chordae.merge_runs", "flag", "true", "", "file: a run of segments without branch becomes one segment of the same length"},
    {"chordae.end_reach", "length", "3 mm", "0.01 mm .. 50 mm", "file: largest distance of a leaflet end from the middle of the leaflet"},
    {"chordae.root_reach", "length", "15 mm", "0.01 mm .. 100 mm", "file: largest distance of a root from a papillary tip or head"},
    {"chordae.gap", "length", "1 mm", "0 mm .. 20 mm", "file: a loose end nearer than this to another piece is joined to it"},

    {"chordae.seed", "integer", "1", "0 .. 2147483647", "density: seed of the random places; the same seed gives the same chordae"},
    {"chordae.border_density", "number", "2", "0 .. 20", "density: leaflet ends per cm of free border; commissures and notches always have one"},
    {"chordae.area_density", "number", "0.6", "0 .. 20", "density: secondary ends per cm2 of leaflet between area_from and area_to"},
    {"chordae.area_from", "number", "0.35", "0 .. 1", "density: secondary ends lie beyond this share of the way from annulus to border"},
    {"chordae.area_to", "number", "0.8", "0 .. 1", "density: and before this share"},
    {"chordae.struts", "integer", "2", "0 .. 2", "density: strut chordae in the belly of the anterior leaflet"},
    {"chordae.branch_levels", "integer", "1", "0 .. 4", "density: how often a border chorda divides in two"},
    {"chordae.branch_share", "number", "0.6", "0 .. 1", "density: share of the border ends that belong to branched chordae"},
    {"chordae.branch_angle", "angle", "40 deg", "5 deg .. 150 deg", "density: angle between the two branches"},
    {"chordae.min_distance", "length?", "auto", "0 mm .. 20 mm", "density: smallest distance between leaflet ends (border ends: along the border); auto: half of what the density gives"},

    {"chordae.cut", "integer[]", "[]", "0 ..", "segments (cells of chordae.vtp, columns of chordae.csv, counted from 0) that are cut during the run"},
    {"chordae.cut_time", "time", "0 s", "0 s ..", "time at which they are cut"},
    {"chordae.anterior.ogden_mu", "pressure[]", "[18.8841 MPa, 22.683 MPa, 19.5029 MPa]", "", "Ogden: mu_i of sum 2 mu_i/alpha_i^2 (l1^alpha_i + l2^alpha_i + l3^alpha_i - 3), incompressible; chordae of the anterior leaflet"},
    {"chordae.anterior.ogden_alpha", "number[]", "[98.2537, 98.2519, 98.2532]", "", "Ogden: alpha_i, exponents"},
    {"chordae.posterior.ogden_mu", "pressure[]", "[4.24155 MPa, 2.7248 MPa, 3.72656e-5 MPa]", "", "Ogden: mu_i, chordae of the posterior leaflet"},
    {"chordae.posterior.ogden_alpha", "number[]", "[55.9149, 55.9155, 70.7151]", "", "Ogden: alpha_i, exponents"},
    {"chordae.septal.ogden_mu", "pressure[]", "[33.7535 MPa, 1.45963e-5 MPa, 0.0203430 MPa]", "", "Ogden: mu_i, chordae of the septal leaflet"},
    {"chordae.septal.ogden_alpha", "number[]", "[0.000153167, 0.000348813, 113.447]", "", "Ogden: alpha_i, exponents"},

    {"annulus.motion", "path", "", "", "CSV of the annulus over time (columns point,time_s,x_mm,y_mm,z_mm; points in order round the annulus, displacements from each point's first row); in blood the tube is made wide enough for it and a skirt of held points closes the gap to the wall; empty: fixed"},

    {"papillary.displacement", "length[3]", "[0 mm, 0 mm, 0 mm]", "-50 mm .. 50 mm", "movement of the papillary tips in the files' frame, reached at move_start + move_time and kept"},
    {"papillary.motion", "path", "", "", "CSV of the papillary tips over time (columns point,time_s,x_mm,y_mm,z_mm; points numbered as in papillary.vtp from 0); added to the displacement"},
    {"papillary.move_start", "time", "0 s", "0 s ..", "time at which the papillary tips start to move"},
    {"papillary.move_time", "time", "20 ms", "0 s ..", "duration of their movement, along a cosine; 0 s: at once"},

    {"fibers.model", "choice arc|parallel|outline|chordae|source|none", "arc", "", "collagen fibre directions: arcs from side to side, parallel to the annulus, along outlined curves, from the chordae, those of the source (a deck's orientations), none (isotropic)"},
    {"fibers.guide", "choice shape|chordae", "shape", "", "arc: the guide has a fixed shape on the flat pattern, or joins the left and right groups of each leaflet's chordae ends"},
    {"fibers.outline", "path", "", "", "outline: curves drawn on the leaflets (.csv x_mm,y_mm,z_mm and curve, .vtp, .mrk.json)"},
    {"fibers.outline_space", "choice ras|lps", "ras", "", "outline: axes of a .csv or .vtp; .mrk.json says its own"},
    {"fibers.outline_reach", "length", "3 mm", "0.01 mm .. 50 mm", "outline: largest distance of a drawn point from the leaflet"},

    {"tube.length_ventricle", "length", "40 mm", "1 mm .. 500 mm", "length of the blood tube on the ventricular side of the annulus plane"},
    {"tube.length_atrium", "length", "20 mm", "1 mm .. 500 mm", "length of the blood tube on the atrial side"},
    {"tube.spacing", "length", "1 mm", "0.05 mm .. 20 mm", "spacing of the fluid grid"},
    {"tube.margin_cells", "integer", "3", "1 .. 50", "grid cells between the tube and the side of the box"},

    {"tube.clearance", "length", "0.25 mm", "0 mm .. 20 mm", "gap between the wall and the outermost leaflet point"},
    {"tube.contain_tips", "flag", "false", "", "widen the tube until the papillary tips lie inside; blood can then pass between annulus and wall"},
    {"tube.harmonics", "integer", "8", "1 .. 100", "Fourier harmonics of the tube's outline"},

    {"gates.min_dihedral", "angle", "10 deg", "0 deg .. 60 deg", "smallest dihedral angle a tetrahedron may have"},
    {"gates.max_dihedral", "angle", "170 deg", "60 deg .. 180 deg", "largest dihedral angle a tetrahedron may have"},
    {"gates.max_spacing_ratio", "number", "0.5", "0.05 .. 10", "largest distance of neighbouring solid points over the fluid spacing"},

    {"gates.max_kinetic_share", "number?", "auto", "0 .. 1e9", "structure only: largest kinetic over elastic energy at the end of a run that counts as at rest; auto: 0.05 with mass scaling (time.target_step), only reported otherwise"},

    {"fluid.enabled", "flag", "true", "", "false puts the pressure straight on the ventricular face (structure only)"},
    {"fluid.density", "density", "1060 kg/m3", "1 kg/m3 .. 20000 kg/m3", "density of blood"},
    {"fluid.viscosity", "viscosity", "2 mPa s", "0 mPa s ..", "dynamic viscosity of blood"},
    {"fluid.kernel", "choice ib4|ib3|cbs32", "ib4", "", "regularised delta function"},

    {"structure.closing_speed", "velocity", "2 m/s", "0.01 m/s .. 1000 m/s", "structure only: speed at which the peak pressure pushes a free leaflet; stands for the blood that is left out"},
    {"structure.settling_time", "time", "1 ms", "0 ms ..", "structure only: time in which a pushed leaflet reaches that speed; leaflets that would need less get more mass (as blood around them would add), which allows longer steps; 0: their own mass"},

    {"leaflet.anterior.law", "choice m1|ogden|hgo|neo_hookean|isotropic_exponential", "m1", "", "tissue law of the anterior leaflet"},
    {"leaflet.anterior.m1_c", "pressure", "17.4 kPa", "0 Pa ..", "M1: c of c (I1-3)"},
    {"leaflet.anterior.m1_a", "pressure", "31.3 kPa", "0 Pa ..", "M1: a of a/(2b) (exp(b (I4-1)^2) - 1)"},
    {"leaflet.anterior.m1_b", "number", "55.93", "0 ..", "M1: b, exponent"},
    {"leaflet.anterior.hgo_c10", "pressure", "2272 Pa", "0 Pa ..", "HGO: C10 of C10 (I1-3)"},
    {"leaflet.anterior.hgo_k1", "pressure", "4000 Pa", "0 Pa ..", "HGO: K1 of K1/(2 K2) (exp(K2 <E>^2) - 1), E = kappa (I1-3) + (1-3 kappa)(I4-1)"},
    {"leaflet.anterior.hgo_k2", "number", "150", "0 ..", "HGO: K2, exponent"},
    {"leaflet.anterior.hgo_kappa", "number", "0.25", "0 .. 0.3333333333333333", "HGO: dispersion kappa, 0 aligned, 1/3 isotropic"},
    {"leaflet.anterior.ogden_mu", "pressure[]", "[-481836.3 Pa, 484166.6 Pa, 742.8 Pa]", "", "Ogden: mu_i of sum 2 mu_i/alpha_i^2 (l1^alpha_i + l2^alpha_i + l3^alpha_i - 3)"},
    {"leaflet.anterior.ogden_alpha", "number[]", "[-19.36, -19.318, -25]", "", "Ogden: alpha_i, exponents"},
    {"leaflet.anterior.neo_mu", "pressure", "20 kPa", "0 Pa ..", "neo-Hookean: mu of mu/2 (I1-3)"},
    {"leaflet.anterior.iso_c0", "pressure", "1000 Pa", "0 Pa ..", "isotropic exponential: C0 of C0/2 (I1-3) + C1/2 (exp(C2 (I1-3)^2) - 1)"},
    {"leaflet.anterior.iso_c1", "pressure", "124 Pa", "0 Pa ..", "isotropic exponential: C1"},
    {"leaflet.anterior.iso_c2", "number", "4.568", "0 ..", "isotropic exponential: C2, exponent"},
    {"leaflet.posterior.law", "choice m1|ogden|hgo|neo_hookean|isotropic_exponential", "m1", "", "tissue law of the posterior leaflet"},
    {"leaflet.posterior.m1_c", "pressure", "10.2 kPa", "0 Pa ..", "M1: c, see the anterior leaflet"},
    {"leaflet.posterior.m1_a", "pressure", "50 kPa", "0 Pa ..", "M1: a, see the anterior leaflet"},
    {"leaflet.posterior.m1_b", "number", "63.48", "0 ..", "M1: b, exponent"},
    {"leaflet.posterior.hgo_c10", "pressure", "2272 Pa", "0 Pa ..", "HGO: C10, see the anterior leaflet"},
    {"leaflet.posterior.hgo_k1", "pressure", "4000 Pa", "0 Pa ..", "HGO: K1, see the anterior leaflet"},
    {"leaflet.posterior.hgo_k2", "number", "150", "0 ..", "HGO: K2, exponent"},
    {"leaflet.posterior.hgo_kappa", "number", "0.25", "0 .. 0.3333333333333333", "HGO: dispersion kappa"},
    {"leaflet.posterior.ogden_mu", "pressure[]", "[-481836.3 Pa, 484166.6 Pa, 742.8 Pa]", "", "Ogden: mu_i, see the anterior leaflet"},
    {"leaflet.posterior.ogden_alpha", "number[]", "[-19.36, -19.318, -25]", "", "Ogden: alpha_i, exponents"},
    {"leaflet.posterior.neo_mu", "pressure", "20 kPa", "0 Pa ..", "neo-Hookean: mu, see the anterior leaflet"},
    {"leaflet.posterior.iso_c0", "pressure", "1000 Pa", "0 Pa ..", "isotropic exponential: C0, see the anterior leaflet"},
    {"leaflet.posterior.iso_c1", "pressure", "188 Pa", "0 Pa ..", "isotropic exponential: C1"},
    {"leaflet.posterior.iso_c2", "number", "14.86", "0 ..", "isotropic exponential: C2, exponent"},
    {"leaflet.septal.law", "choice m1|ogden|hgo|neo_hookean|isotropic_exponential", "m1", "", "tissue law of the septal leaflet (tricuspid valves)"},
    {"leaflet.septal.m1_c", "pressure", "10.2 kPa", "0 Pa ..", "M1: c, see the anterior leaflet"},
    {"leaflet.septal.m1_a", "pressure", "50 kPa", "0 Pa ..", "M1: a, see the anterior leaflet"},
    {"leaflet.septal.m1_b", "number", "63.48", "0 ..", "M1: b, exponent"},
    {"leaflet.septal.hgo_c10", "pressure", "2272 Pa", "0 Pa ..", "HGO: C10, see the anterior leaflet"},
    {"leaflet.septal.hgo_k1", "pressure", "4000 Pa", "0 Pa ..", "HGO: K1, see the anterior leaflet"},
    {"leaflet.septal.hgo_k2", "number", "150", "0 ..", "HGO: K2, exponent"},
    {"leaflet.septal.hgo_kappa", "number", "0.25", "0 .. 0.3333333333333333", "HGO: dispersion kappa"},
    {"leaflet.septal.ogden_mu", "pressure[]", "[-481836.3 Pa, 484166.6 Pa, 742.8 Pa]", "", "Ogden: mu_i, see the anterior leaflet"},
    {"leaflet.septal.ogden_alpha", "number[]", "[-19.36, -19.318, -25]", "", "Ogden: alpha_i, exponents"},
    {"leaflet.septal.neo_mu", "pressure", "20 kPa", "0 Pa ..", "neo-Hookean: mu, see the anterior leaflet"},
    {"leaflet.septal.iso_c0", "pressure", "1000 Pa", "0 Pa ..", "isotropic exponential: C0, see the anterior leaflet"},
    {"leaflet.septal.iso_c1", "pressure", "191 Pa", "0 Pa ..", "isotropic exponential: C1"},
    {"leaflet.septal.iso_c2", "number", "17.75", "0 ..", "isotropic exponential: C2, exponent"},
    {"leaflet.exponent_limit", "number?", "auto", "0.1 .. 100", "exponents are followed up to this value, from there on the law continues as its tangent parabola; auto: 4, for isotropic_exponential 10"},
    {"leaflet.bulk", "pressure", "1 MPa", "0 Pa ..", "volumetric stiffness (see solver/solid)"},
    {"leaflet.poisson_ratio", "number?", "auto", "0 .. 0.4999", "numerical Poisson's ratio nu: each leaflet's volumetric stiffness becomes 2 mu (1 + nu) / (3 (1 - 2 nu)), mu its shear modulus at rest; auto: leaflet.bulk"},
    {"leaflet.density", "density", "1060 kg/m3", "1 kg/m3 .. 20000 kg/m3", "density of the leaflets"},
    {"leaflet.distortion_strain", "number", "0.9", "0.01 .. 0.99", "strain beyond which an element stiffens (distortion control)"},
    {"leaflet.distortion_factor", "number", "4", "0 .. 1e6", "how many times stiffer a distorted element becomes; 0 switches the control off"},

    {"contact.enabled", "flag", "true", "", "contact between the leaflets"},
    {"contact.friction", "number", "0.2", "0 .. 10", "Coulomb coefficient; 0 leaves friction out"},
    {"contact.faces", "choice both|inner", "both", "", "faces that can touch: both, or the atrial (inner) faces only"},
    {"contact.threshold", "length?", "auto", "0 mm .. 10 mm", "gap below which faces count as touching: verdict, belt and map; auto: the fluid spacing, below which the grid carries no flow (contact.range without blood)"},
    {"contact.range", "length?", "auto", "0.001 mm .. 10 mm", "gap below which faces push each other apart; auto: half the fluid spacing, at most the thickness"},
    {"contact.stiffness", "number", "1", "0 .. 1000", "factor on the penalty stiffness, which carries the largest pressure of the run at a gap of a quarter of contact.range"},
    {"contact.search_every", "integer", "0", "0 .. 1000", "steps between two searches for candidates; 0: when the leaflets have moved far enough"},

    {"coupling.scheme", "choice interpolation|drained", "drained", "", "how leaflets and blood are coupled (solver/README.md)"},
    {"coupling.relaxation", "flag", "true", "", "relax distortion shorter than the kernel, which the blood does not see"},
    {"coupling.annulus", "choice points|faces", "points", "", "how the annulus keeps the blood at rest: by its nodes within their kernels, which narrows the orifice by up to two cells, or by the grid faces that its tissue crosses"},
    {"coupling.drainage_time", "time", "5 ms", "0.5 ms ..", "drained: time in which a blood film as thick as a fluid cell drains between facing leaflets under the peak pressure"},

    {"pressure.waveform", "choice systolic|ramp|smooth|csv", "systolic", "", "ventricular minus atrial pressure: rise along a cosine and hold, straight ramp and hold, smooth step (10 s^3 - 15 s^4 + 6 s^5) and hold, or a file"},
    {"pressure.peak", "pressure", "120 mmHg", "-300 mmHg .. 500 mmHg", "plateau of the built-in waveforms"},
    {"pressure.rise_time", "time", "60 ms", "0.01 ms .. 10000 ms", "time from zero to the plateau"},
    {"pressure.csv", "path", "", "", "CSV of the pressures, first line with column names"},
    {"pressure.csv_start", "time", "0 s", "", "time in the file at which the simulation starts"},
    {"pressure.csv_time_column", "text", "", "", "name of the time column; empty for the first"},
    {"pressure.csv_columns", "text[]", "[]", "", "one column: the difference itself; two: ventricle, atrium; empty for the second column"},
    {"pressure.csv_time_unit", "choice s|ms", "s", "", "unit of the time column"},
    {"pressure.csv_pressure_unit", "choice mmHg|kPa|Pa", "mmHg", "", "unit of the pressure columns"},

    {"time.end", "time", "0.25 s", "0 s .. 1000 s", "simulated time"},
    {"time.step_max", "time", "50 us", "0.001 us .. 10000 us", "largest step"},
    {"time.target_step", "time?", "auto", "0.001 us .. 10000 us", "structure only: masses of nodes are raised until this step is stable for the elements and chordae around them at rest (mass scaling, for quasi-static closure); auto: true masses"},
    {"time.safety", "number", "0.8", "0.01 .. 1", "share of the estimated stable step that is used"},
    {"time.step_fixed", "time?", "auto", "0.001 us .. 10000 us", "fixed step instead of the adaptive one"},

    {"output.frames_every", "time", "10 ms", "0.001 ms ..", "time between two frames of the leaflets"},
    {"output.fluid_every", "time", "50 ms", "0.001 ms ..", "time between two frames of the fluid"},
    {"output.series_every", "time", "1 ms", "0.001 ms ..", "time between two lines of series.csv"},
    {"output.checkpoint_every", "time", "50 ms", "0.001 ms ..", "time between two checkpoints"},
    // clang-format on
};

Dimension dimension_of(const std::string& name) {
  for (int d = 0; d <= static_cast<int>(Dimension::flow); ++d) {
    const auto dimension = static_cast<Dimension>(d);
    if (dimension_name(dimension) == name) return dimension;
  }
  if (name == "flow") return Dimension::flow;
  throw std::logic_error("unknown type in the schema: " + name);
}

/// "0.5 mm" -> "mm"
std::string unit_in(const std::string& text, Dimension dimension) {
  std::string best;
  for (const std::string& unit : units_of(dimension)) {
    const auto at = text.find(" " + unit);
    if (at == std::string::npos) continue;
    const auto end = at + 1 + unit.size();
    const bool whole = end == text.size() || text[end] == ',' || text[end] == ']' || text[end] == ' ';
    if (whole && unit.size() > best.size()) best = unit;
  }
  return best;
}

void read_type(const Row& row, ConfigKey& key) {
  std::string type = row.type;
  if (type.starts_with("choice ")) {
    key.type = "choice";
    for (std::size_t at = 7; at <= type.size();) {
      const std::size_t bar = std::min(type.find('|', at), type.size());
      key.choices.push_back(type.substr(at, bar - at));
      at = bar + 1;
    }
    return;
  }
  if (type.ends_with('?')) key.can_be_auto = true, type.pop_back();
  bool is_list = false;
  if (const auto bracket = type.find('['); bracket != std::string::npos) {
    is_list = true;
    key.count = std::strtoul(type.c_str() + bracket + 1, nullptr, 10);
    type.resize(bracket);
  }
  if (type == "flag")
    key.type = "bool";
  else if (type == "integer")
    key.type = is_list ? "integers" : "integer";
  else if (type == "text")
    key.type = is_list ? "strings" : "string";
  else if (type == "path")
    key.type = is_list ? "paths" : "path";
  else {
    key.type = is_list ? "numbers" : "number";
    key.dimension = dimension_of(type);
  }
}

void read_range(const Row& row, ConfigKey& key) {
  const std::string range = row.range;
  if (range.empty()) return;
  const auto dots = range.find("..");
  const std::string low = range.substr(0, dots), high = range.substr(dots + 2);
  const std::string what = std::string("range of ") + row.name;
  if (low.find_first_not_of(' ') != std::string::npos) key.minimum = parse_quantity(low, key.dimension, what);
  if (high.find_first_not_of(' ') != std::string::npos) key.maximum = parse_quantity(high, key.dimension, what);
}

ConfigKey key_of(const Row& row) {
  ConfigKey key;
  key.name = row.name;
  key.doc = row.doc;
  read_type(row, key);
  if (key.dimension != Dimension::none) {
    key.unit = unit_in(row.default_text, key.dimension);
    if (key.unit.empty()) key.unit = unit_in(row.range, key.dimension);
    if (key.unit.empty()) throw std::logic_error(std::string("no unit in the schema row of ") + row.name);
  }
  read_range(row, key);
  key.default_value = value_from_text(key, row.default_text, "schema");
  return key;
}

}  // namespace

const std::vector<ConfigKey>& config_schema() {
  static const std::vector<ConfigKey> schema = [] {
    std::vector<ConfigKey> keys;
    for (const Row& row : rows) keys.push_back(key_of(row));
    return keys;
  }();
  return schema;
}

const ConfigKey& config_key(const std::string& name) {
  for (const ConfigKey& key : config_schema()) {
    if (key.name == name) return key;
  }
  throw std::logic_error("the schema has no key '" + name + "'");
}

}  // namespace mv
