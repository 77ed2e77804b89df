// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/vtk_dataset.h"

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLImageDataWriter.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <cassert>
#include <cmath>
#include <mutex>
#include <new>
#include <stdexcept>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

const std::string hash_opens = "<!-- sha256 ";
const std::string hash_closes = " -->\n";

/// Takes every VTK error, also those of objects inside a reader, instead of printing it.
class ErrorCollector : public vtkOutputWindow {
 public:
  vtkTypeMacro(ErrorCollector, vtkOutputWindow) static ErrorCollector* New();
  void DisplayText(const char*) override {}
  void DisplayErrorText(const char* message) override {
    if (first_error.empty() && message) first_error = message;
  }
  std::string first_error;
};
vtkStandardNewMacro(ErrorCollector)

    /// Redirects VTK's messages, which are global, to a collector while it lives.
    class CollectErrors {
 public:
  CollectErrors()
      : lock_(mutex()), previous_(vtkOutputWindow::GetInstance()), verbosity_(vtkLogger::GetCurrentVerbosityCutoff()) {
    vtkOutputWindow::SetInstance(collector_);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  }
  ~CollectErrors() {
    vtkLogger::SetStderrVerbosity(verbosity_);
    vtkOutputWindow::SetInstance(previous_);
  }
  CollectErrors(const CollectErrors&) = delete;
  CollectErrors& operator=(const CollectErrors&) = delete;
  const std::string& first() const { return collector_->first_error; }

 private:
  static std::mutex& mutex() {
    static std::mutex m;
    return m;
  }
  std::lock_guard<std::mutex> lock_;
  vtkNew<ErrorCollector> collector_;
  vtkSmartPointer<vtkOutputWindow> previous_;
  vtkLogger::Verbosity verbosity_;
};

/// Last line of a VTK message, which carries the meaning.
std::string essence(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  const auto colon = text.rfind("): ");
  if (colon != std::string::npos) text = text.substr(colon + 3);
  for (char& c : text) {
    if (c == '\n') c = ' ';
  }
  return text;
}

template <class Writer>
std::string bytes_of(vtkDataObject* data) {
  vtkNew<Writer> writer;
  writer->SetInputDataObject(data);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToZLib();
  writer->SetCompressionLevel(1);  // half the time of the default for a few per cent of the size
  writer->SetHeaderTypeToUInt64();
  writer->WriteToOutputStringOn();
  if (!writer->Write()) throw std::runtime_error("VTK could not serialise the data");
  return writer->GetOutputString();
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
  throw InputError(file.string() + ": " + why + "; write the case again with mvprep");
}

/// Takes the SHA-256 line off, after checking it.
std::string checked_bytes(const std::filesystem::path& file) {
  std::string bytes = read_file(file);
  const auto at = bytes.rfind(hash_opens);
  if (at != std::string::npos && bytes.size() == at + hash_opens.size() + 64 + hash_closes.size()) {
    const std::string recorded = bytes.substr(at + hash_opens.size(), 64);
    bytes.resize(at);
    if (sha256(bytes) != recorded) refuse(file, "damaged: the content does not fit its SHA-256 line");
  }
  const auto end = bytes.find_last_not_of(" \t\r\n");
  const std::string_view closing = "</VTKFile>";
  if (end == std::string::npos || end + 1 < closing.size() ||
      std::string_view(bytes).substr(end + 1 - closing.size(), closing.size()) != closing) {
    refuse(file, "incomplete: it does not end with </VTKFile>");
  }
  return bytes;
}

template <class Reader, class Data>
vtkSmartPointer<Data> read_with(const std::filesystem::path& file, const char* kind, bool is_ours = true) {
  const std::string bytes = checked_bytes(file);
  if (bytes.find(std::string("type=\"") + kind + "\"") == std::string::npos)
    refuse(file, std::string("not a VTK XML file of type ") + kind);
  const CollectErrors errors;
  vtkNew<Reader> reader;
  reader->ReadFromInputStringOn();
  reader->SetInputString(bytes);
  try {
    reader->Update();
  } catch (const std::bad_alloc&) {
    refuse(file, "damaged: it announces more data than fit into memory");
  } catch (const std::length_error&) {
    refuse(file, "damaged: it announces more data than fit into memory");
  }
  if (!errors.first().empty() || reader->GetErrorCode() != 0) refuse(file, "damaged: " + essence(errors.first()));
  vtkSmartPointer<Data> data = reader->GetOutput();
  if (!data) refuse(file, "damaged: nothing could be read");
  if (!is_ours) return data;
  const DatasetReader check(file, data);
  for (const auto& [name, value] : {std::pair<std::string, std::string>{"UnitSystem", "mm"}, {"SPACE", "RAS"}}) {
    const auto texts = check.texts(name);
    if (texts.size() != 1 || texts[0] != value)
      check.fail(name, "is \"" + (texts.empty() ? "" : texts[0]) + "\", expected \"" + value + "\"");
  }
  return data;
}

template <class Array, class T>
vtkSmartPointer<vtkDataArray> filled(const std::string& name, std::span<const T> values, int components) {
  assert(values.size() % static_cast<std::size_t>(components) == 0);
  auto array = vtkSmartPointer<Array>::New();
  array->SetName(name.c_str());
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(static_cast<vtkIdType>(values.size()) / components);
  for (std::size_t i = 0; i < values.size(); ++i) {
    array->SetValue(static_cast<vtkIdType>(i), static_cast<typename Array::ValueType>(values[i]));
  }
  return array;
}

}  // namespace

void add_units(vtkDataObject* data, const ArrayUnits& units) {
  vtkFieldData* field = data->GetFieldData();
  add_texts(field, "UnitSystem", {"mm"});
  add_texts(field, "SPACE", {"RAS"});
  for (const auto& [name, unit] : units) add_texts(field, "unit:" + name, {unit});
}

vtkSmartPointer<vtkDataArray> real_array(const std::string& name, std::span<const double> values, int components) {
  return filled<vtkDoubleArray>(name, values, components);
}
vtkSmartPointer<vtkDataArray> integer_array(const std::string& name, std::span<const int> values, int components) {
  return filled<vtkIntArray>(name, values, components);
}
vtkSmartPointer<vtkDataArray> byte_array(const std::string& name, std::span<const char> values) {
  return filled<vtkUnsignedCharArray>(name, values, 1);
}

void add_texts(vtkFieldData* data, const std::string& name, const std::vector<std::string>& texts) {
  auto array = vtkSmartPointer<vtkStringArray>::New();
  array->SetName(name.c_str());
  for (const auto& t : texts) array->InsertNextValue(t);
  data->AddArray(array);
}

void write_vtk(const std::filesystem::path& file, vtkDataObject* data) {
  std::string bytes;
  if (vtkPolyData::SafeDownCast(data))
    bytes = bytes_of<vtkXMLPolyDataWriter>(data);
  else if (vtkUnstructuredGrid::SafeDownCast(data))
    bytes = bytes_of<vtkXMLUnstructuredGridWriter>(data);
  else if (vtkImageData::SafeDownCast(data))
    bytes = bytes_of<vtkXMLImageDataWriter>(data);
  else
    throw std::logic_error("write_vtk: unsupported kind of data");
  if (!bytes.ends_with('\n')) bytes += '\n';
  bytes += hash_opens + sha256(bytes) + hash_closes;
  write_text_atomically(file, bytes);
}

vtkSmartPointer<vtkUnstructuredGrid> read_unstructured_grid(const std::filesystem::path& file) {
  return read_with<vtkXMLUnstructuredGridReader, vtkUnstructuredGrid>(file, "UnstructuredGrid");
}
vtkSmartPointer<vtkPolyData> read_poly_data(const std::filesystem::path& file) {
  return read_with<vtkXMLPolyDataReader, vtkPolyData>(file, "PolyData");
}

vtkSmartPointer<vtkPolyData> read_foreign_poly_data(const std::filesystem::path& file) {
  return read_with<vtkXMLPolyDataReader, vtkPolyData>(file, "PolyData", false);
}

void DatasetReader::fail(const std::string& array, const std::string& why) const {
  refuse(file_, "array '" + array + "' " + why);
}

vtkDataArray* DatasetReader::array(Place place, const std::string& name) const {
  vtkFieldData* data = place == Place::points  ? data_->GetPointData()
                       : place == Place::cells ? static_cast<vtkFieldData*>(data_->GetCellData())
                                               : data_->GetFieldData();
  return data ? data->GetArray(name.c_str()) : nullptr;
}

bool DatasetReader::has(Place place, const std::string& name) const { return array(place, name) != nullptr; }

std::vector<double> DatasetReader::reals(Place place, const std::string& name, int components, long tuples) const {
  vtkDataArray* values = array(place, name);
  if (!values) {
    if (tuples == 0) return {};
    fail(name, "is missing");
  }
  if (values->GetNumberOfTuples() == 0 && tuples <= 0) return {};
  if (values->GetNumberOfComponents() != components) {
    fail(name, "has " + std::to_string(values->GetNumberOfComponents()) + " components, expected " + std::to_string(components));
  }
  if (tuples >= 0 && values->GetNumberOfTuples() != tuples) {
    fail(name, "has " + std::to_string(values->GetNumberOfTuples()) + " entries, expected " + std::to_string(tuples));
  }
  std::vector<double> out(static_cast<std::size_t>(values->GetNumberOfValues()));
  for (vtkIdType t = 0; t < values->GetNumberOfTuples(); ++t) {
    for (int c = 0; c < components; ++c) {
      const double v = values->GetComponent(t, c);
      if (!std::isfinite(v)) fail(name, "is not finite at entry " + std::to_string(t));
      out[static_cast<std::size_t>(t * components + c)] = v;
    }
  }
  return out;
}

std::vector<int> DatasetReader::integers(Place place, const std::string& name, long low, long high, int components,
                                         long tuples) const {
  const std::vector<double> values = reals(place, name, components, tuples);
  std::vector<int> out(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] != std::floor(values[i]) || values[i] < static_cast<double>(low) || values[i] > static_cast<double>(high)) {
      fail(name, "holds " + std::to_string(values[i]) + " at entry " + std::to_string(i / static_cast<std::size_t>(components)) +
                     ", expected a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    }
    out[i] = static_cast<int>(values[i]);
  }
  return out;
}

std::vector<std::string> DatasetReader::texts(const std::string& name) const {
  auto* values = vtkStringArray::SafeDownCast(data_->GetFieldData()->GetAbstractArray(name.c_str()));
  std::vector<std::string> out;
  for (vtkIdType i = 0; values && i < values->GetNumberOfValues(); ++i) out.push_back(values->GetValue(i));
  return out;
}

std::vector<double> DatasetReader::coordinates() const {
  std::vector<double> out(static_cast<std::size_t>(data_->GetNumberOfPoints()) * 3);
  for (vtkIdType p = 0; p < data_->GetNumberOfPoints(); ++p) {
    double* x = out.data() + 3 * p;
    data_->GetPoint(p, x);
    if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
      fail("points", "is not finite at point " + std::to_string(p));
  }
  return out;
}

void DatasetReader::expect_unit(const std::string& name, const std::string& unit) const {
  const auto recorded = texts("unit:" + name);
  if (!recorded.empty() && recorded[0] != unit) fail(name, "is in \"" + recorded[0] + "\", expected \"" + unit + "\"");
}

}  // namespace mv
