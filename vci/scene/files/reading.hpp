// Turns errors of the JSON and VTK libraries on damaged files into errors that name the file.
#pragma once
#include "common/error.hpp"

#include <cmath>
#include <filesystem>
#include <string>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

namespace vci {

/// The polydata of a .vtp file. Throws common::InputError if the file is missing, is of another type, or makes VTK
/// report an error. VTK itself prints nothing to standard error.
/// @param what word for the file's content in messages, such as "lumen"
vtkSmartPointer<vtkPolyData> read_polydata(const std::filesystem::path& file, const std::string& what);

/// A length in mm rounded to the nanometre, so that last digits in a file do not matter.
inline double rounded_to_nanometre(double mm) {
  return std::round(mm * 1e6) / 1e6;
}

/// Calls the function `read`. Exceptions that JSON or VTK throw over a damaged file (overflow, a size beyond memory, a
/// value of another type) become an InputError that names the file.
template <class Read> auto guarded_read(const std::filesystem::path& file, Read&& read) {
  try {
    return read();
  } catch (const common::InputError&) {
    throw;
  } catch (const std::exception& e) {
    throw common::InputError("the file cannot be used", file.string(), e.what(), "it is damaged: write it anew");
  }
}

} // namespace vci
