// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// VTK XML files in memory: one way of writing them (appended, raw, zlib, field data with units, SHA-256 at the end) and of
// reading them with every defect turned into an InputError. Included by .cpp files only.

#include <vtkSmartPointer.h>

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

class vtkDataArray;
class vtkDataObject;
class vtkDataSet;
class vtkFieldData;
class vtkPolyData;
class vtkUnstructuredGrid;

namespace mv {

/// Pairs of array name and unit; "1" for numbers without a unit, "points" names the coordinates.
using ArrayUnits = std::vector<std::pair<std::string, std::string>>;

/// Adds the field data UnitSystem ("mm"), SPACE ("RAS") and "unit:NAME" for each pair.
void add_units(vtkDataObject* data, const ArrayUnits& units);

/// Arrays of one or more components; the values are copied. `components` must divide the size.
vtkSmartPointer<vtkDataArray> real_array(const std::string& name, std::span<const double> values, int components = 1);
vtkSmartPointer<vtkDataArray> integer_array(const std::string& name, std::span<const int> values, int components = 1);
vtkSmartPointer<vtkDataArray> byte_array(const std::string& name, std::span<const char> values);
/// Field data of texts.
void add_texts(vtkFieldData* data, const std::string& name, const std::vector<std::string>& texts);

/// Writes .vtu, .vtp or .vti (by the type of `data`) through a temporary name and a rename.
/// The same data give the same bytes. The last line is an XML
/// comment with the SHA-256 of what precedes it. Throws IoError.
void write_vtk(const std::filesystem::path& file, vtkDataObject* data);

/// Reads and checks the SHA-256 line if there is one (a file saved by other programs has none). Throws IoError when the
/// file cannot be opened, InputError when it is damaged, incomplete, of another kind, or of another unit or space.
vtkSmartPointer<vtkUnstructuredGrid> read_unstructured_grid(const std::filesystem::path& file);
vtkSmartPointer<vtkPolyData> read_poly_data(const std::filesystem::path& file);
/// A .vtp of another program: unit and space are the caller's business.
vtkSmartPointer<vtkPolyData> read_foreign_poly_data(const std::filesystem::path& file);

/// The arrays of one file with their checks. Every failure is an InputError that names file and array.
class DatasetReader {
 public:
  enum class Place { points, cells, field };
  DatasetReader(std::filesystem::path file, vtkDataSet* data) : file_(std::move(file)), data_(data) {}

  bool has(Place place, const std::string& name) const;
  /// `tuples` < 0 takes any number. Checks component count, tuple count, finiteness.
  std::vector<double> reals(Place place, const std::string& name, int components, long tuples) const;
  /// Checks besides that every value is a whole number from `low` to `high`.
  std::vector<int> integers(Place place, const std::string& name, long low, long high, int components, long tuples) const;
  std::vector<std::string> texts(const std::string& name) const;
  /// Coordinates, finite.
  std::vector<double> coordinates() const;
  /// The unit recorded for the array must be this one; nothing recorded is accepted.
  void expect_unit(const std::string& name, const std::string& unit) const;
  [[noreturn]] void fail(const std::string& array, const std::string& why) const;

 private:
  vtkDataArray* array(Place place, const std::string& name) const;

  std::filesystem::path file_;
  vtkDataSet* data_;
};

}  // namespace mv
