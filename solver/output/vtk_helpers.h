// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Private to this folder's .cpp files: the few VTK idioms they share.

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLWriter.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <system_error>

#include "geometry/core/case.h"
#include "geometry/core/errors.h"

namespace mv::vtk {

inline void add_text(vtkFieldData* field, const std::string& name, const std::string& value) {
  vtkNew<vtkStringArray> array;
  array->SetName(name.c_str());
  array->InsertNextValue(value);
  field->AddArray(array);
}

template <class Array>
void add_numbers(vtkFieldData* field, const std::string& name, std::initializer_list<double> values) {
  vtkNew<Array> array;
  array->SetName(name.c_str());
  for (double v : values) array->InsertNextValue(v);
  field->AddArray(array);
}

/// Field data every file carries: frame, unit system, unit of the coordinates, time.
inline void add_header(vtkFieldData* field, double time) {
  add_text(field, "UnitSystem", "mm");
  add_text(field, "SPACE", "RAS");
  add_text(field, "unit:points", "mm");
  add_numbers<vtkDoubleArray>(field, "TimeValue", {time});
  add_text(field, "unit:TimeValue", "s");
}

/// Adds `count` tuples value(i) (a number) as array `name` with its unit.
template <class Array, class Value>
void add_scalars(vtkDataSet* data, vtkDataSetAttributes* where, const std::string& name, const std::string& unit,
                 std::ptrdiff_t count, Value&& value) {
  vtkNew<Array> array;
  array->SetName(name.c_str());
  array->SetNumberOfTuples(count);
  using Entry = typename Array::ValueType;
  for (std::ptrdiff_t i = 0; i < count; ++i) array->SetValue(i, static_cast<Entry>(value(i)));
  where->AddArray(array);
  if (!data->GetFieldData()->HasArray(("unit:" + name).c_str())) add_text(data->GetFieldData(), "unit:" + name, unit);
}

/// The same for vectors: value(i) is an Eigen vector of `components` entries.
template <class Array, class Value>
void add_vectors(vtkDataSet* data, vtkDataSetAttributes* where, const std::string& name, const std::string& unit,
                 int components, std::ptrdiff_t count, Value&& value) {
  vtkNew<Array> array;
  array->SetName(name.c_str());
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(count);
  using Entry = typename Array::ValueType;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const auto v = value(i);
    for (int c = 0; c < components; ++c) array->SetTypedComponent(i, c, static_cast<Entry>(v[c]));
  }
  where->AddArray(array);
  add_text(data->GetFieldData(), "unit:" + name, unit);
}

/// The file's bytes, compressed and in raw appended form.
template <class Writer>
std::string to_bytes(vtkDataObject* data) {
  vtkNew<Writer> writer;
  writer->SetInputData(data);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToZLib();
  writer->WriteToOutputStringOn();
  if (writer->Write() == 0) throw IoError("VTK could not serialise a data set");
  return writer->GetOutputString();
}

/// Runs a VTK XML reader on `file` without letting VTK print. Throws IoError when missing, InputError when VTK reports damage.
template <class Reader>
void run_reader(Reader* reader, const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) throw IoError(file.string() + ": no such file");
  const int display = vtkObject::GetGlobalWarningDisplay();
  vtkObject::GlobalWarningDisplayOff();
  const bool readable = reader->CanReadFile(file.c_str()) != 0;
  if (readable) {
    reader->SetFileName(file.c_str());
    reader->Update();
  }
  vtkObject::SetGlobalWarningDisplay(display);
  if (!readable || reader->GetErrorCode() != 0 || reader->GetOutput() == nullptr)
    throw InputError(file.string() + ": not a readable VTK file of the expected kind (damaged or incomplete?)");
}

/// Array `name` with the expected shape, or nullptr when absent and not required. Throws InputError for a wrong shape or, unless
/// `may_be_nan`, a value that is not finite.
inline vtkDataArray* find_array(vtkFieldData* where, const std::filesystem::path& file, const std::string& name, int components,
                                std::ptrdiff_t tuples, bool required, bool may_be_nan = false) {
  vtkDataArray* array = where->GetArray(name.c_str());
  if (array == nullptr) {
    if (required) throw InputError(file.string() + ": array '" + name + "' is missing");
    return nullptr;
  }
  if (array->GetNumberOfComponents() != components || array->GetNumberOfTuples() != tuples)
    throw InputError(file.string() + ": array '" + name + "' has " + std::to_string(array->GetNumberOfTuples()) + " x " +
                     std::to_string(array->GetNumberOfComponents()) + " values, expected " + std::to_string(tuples) + " x " +
                     std::to_string(components));
  for (std::ptrdiff_t i = 0; i < tuples && !may_be_nan; ++i)
    for (int c = 0; c < components; ++c)
      if (!std::isfinite(array->GetComponent(i, c)))
        throw InputError(file.string() + ": array '" + name + "' entry " + std::to_string(i) + " is not finite");
  return array;
}

inline Vec3 vector_at(vtkDataArray* array, std::ptrdiff_t i) {
  return {array->GetComponent(i, 0), array->GetComponent(i, 1), array->GetComponent(i, 2)};
}

template <class T>
std::vector<T> scalars_of(vtkDataArray* array) {
  std::vector<T> values;
  if (array == nullptr) return values;
  values.resize(static_cast<std::size_t>(array->GetNumberOfTuples()));
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = static_cast<T>(array->GetComponent(static_cast<vtkIdType>(i), 0));
  return values;
}

inline std::vector<Vec3> vectors_of(vtkDataArray* array) {
  std::vector<Vec3> values;
  if (array == nullptr) return values;
  values.resize(static_cast<std::size_t>(array->GetNumberOfTuples()));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = vector_at(array, static_cast<vtkIdType>(i));
  return values;
}

inline double field_number(vtkFieldData* field, const char* name, double fallback) {
  vtkDataArray* array = field->GetArray(name);
  return array != nullptr && array->GetNumberOfValues() > 0 ? array->GetComponent(0, 0) : fallback;
}

}  // namespace mv::vtk
