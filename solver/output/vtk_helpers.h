// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Private to this folder's .cpp files: arrays from a rule, in single precision where a picture is all they are for, each with its
// unit.

#include <vtkCellData.h>
#include <vtkDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>

#include <initializer_list>
#include <string>
#include <vector>

#include "geometry/core/case.h"
#include "geometry/core/vtk_dataset.h"

namespace mv::vtk {

/// One tuple of field data.
inline void add_field(vtkDataSet* data, const std::string& name, const std::string& unit, std::initializer_list<double> values) {
  vtkNew<vtkDoubleArray> array;
  array->SetName(name.c_str());
  array->SetNumberOfComponents(static_cast<int>(values.size()));
  array->SetNumberOfTuples(1);
  int c = 0;
  for (double v : values) array->SetTypedComponent(0, c++, v);
  data->GetFieldData()->AddArray(array);
  add_texts(data->GetFieldData(), "unit:" + name, {unit});
}

/// Field data every frame carries: frame, unit system, unit of the coordinates, time.
inline void add_header(vtkDataSet* data, double time) {
  add_units(data, {{"points", "mm"}});
  add_field(data, "TimeValue", "s", {time});
}

/// Array `name` of `count` entries value(i), numbers for one component, Eigen vectors for more.
template <class Array, class Value>
void add_array(vtkDataSet* data, vtkFieldData* where, const std::string& name, const std::string& unit, int components,
               std::size_t count, Value&& value) {
  vtkNew<Array> array;
  array->SetName(name.c_str());
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(static_cast<vtkIdType>(count));
  using Entry = typename Array::ValueType;
  for (std::size_t i = 0; i < count; ++i) {
    const auto v = value(i);
    if constexpr (std::is_arithmetic_v<std::decay_t<decltype(v)>>) {
      array->SetValue(static_cast<vtkIdType>(i), static_cast<Entry>(v));
    } else {
      for (int c = 0; c < components; ++c) array->SetTypedComponent(static_cast<vtkIdType>(i), c, static_cast<Entry>(v[c]));
    }
  }
  where->AddArray(array);
  add_texts(data->GetFieldData(), "unit:" + name, {unit});
}

inline std::vector<Vec3> to_vectors(const std::vector<double>& xyz) {
  std::vector<Vec3> out(xyz.size() / 3);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = Vec3(xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]);
  return out;
}

}  // namespace mv::vtk
