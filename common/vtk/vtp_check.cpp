#include "common/vtk/vtp_check.hpp"
#include "common/error.hpp"
#include "common/vtk/vtp_arrays.hpp"

#include <array>
#include <cstring>
#include <fstream>
#include <set>
#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>

namespace common {

namespace {

constexpr int most_components = 1000; // most components of an array: VTK's reader looks for a name of each one

bool has_name(vtkXMLDataElement* element, const char* name) {
  return std::strcmp(element->GetName(), name) == 0;
}

template <class Visit> void for_each_nested(vtkXMLDataElement* parent, Visit&& visit) {
  for (int k = 0; k < parent->GetNumberOfNestedElements(); ++k)
    visit(parent->GetNestedElement(k));
}

/// The number in an attribute of an element, such as NumberOfPoints; 0 without the attribute. Throws DamagedFile if the
/// text is no number or the number is negative.
std::uint64_t count_attribute(vtkXMLDataElement* element, const char* attribute) {
  long long count = 0;
  if (element->GetAttribute(attribute) && !element->GetScalarAttribute(attribute, count))
    throw DamagedFile(std::string(attribute) + " is no number");
  if (count < 0)
    throw DamagedFile(std::string(attribute) + " is negative");
  return static_cast<std::uint64_t>(count);
}

struct ArrayHeader {
  vtkXMLDataElement* element;
  std::string name;
  int type; ///< VTK's number of the values' type, for example VTK_DOUBLE
  std::uint64_t components;
};

ArrayHeader read_array_header(vtkXMLDataElement* element) {
  const char* name = element->GetAttribute("Name");
  if (!(has_name(element, "DataArray") || has_name(element, "Array")))
    throw DamagedFile(std::string("an element ") + element->GetName() + " where an array is expected");
  ArrayHeader array{element, name ? name : "", 0, 1};
  if (!element->GetWordTypeAttribute("type", array.type) || array.type == VTK_BIT)
    throw DamagedFile("an array of no known type: " + array.name);
  if (element->GetAttribute("NumberOfComponents"))
    array.components = count_attribute(element, "NumberOfComponents");
  if (array.components < 1 || array.components > most_components)
    throw DamagedFile("an array of " + std::to_string(array.components) + " components: " + array.name);
  return array;
}

/// The values of the first `tuples` tuples of an array, as bytes. Throws DamagedFile if the file holds fewer.
std::vector<unsigned char> read(VtpArrays& file, const ArrayHeader& a, std::uint64_t tuples) {
  if (tuples > UINT64_MAX / most_components)
    throw DamagedFile("more values than any file holds: " + a.name);
  try {
    return file.read(a.element, a.type, tuples * a.components);
  } catch (const DamagedFile& e) {
    throw DamagedFile(std::string(e.what()) + ": " + a.name);
  }
}

void check_attributes(VtpArrays& file, vtkXMLDataElement* group, std::uint64_t tuples) {
  std::set<std::string> names;
  for_each_nested(group, [&](vtkXMLDataElement* element) {
    const ArrayHeader a = read_array_header(element);
    if (a.name.empty() || !names.insert(a.name).second)
      throw DamagedFile("an array without a name of its own: " + a.name);
    read(file, a, tuples);
  });
}

/// Checks a group of cells. Its array `connectivity` lists the point numbers of all cells, one cell after another. Its
/// array `offsets` has the place in that list where each cell ends.
void check_cells(VtpArrays& file, vtkXMLDataElement* group, std::uint64_t cells) {
  vtkXMLDataElement *ends = nullptr, *points = nullptr;
  for_each_nested(group, [&](vtkXMLDataElement* element) {
    const ArrayHeader a = read_array_header(element);
    if (!ends && a.name == "offsets")
      ends = element;
    if (!points && a.name == "connectivity")
      points = element;
  });
  if (cells == 0)
    return;
  if (!ends || !points)
    throw DamagedFile(std::string(group->GetName()) + " without offsets and connectivity");
  const ArrayHeader offsets = read_array_header(ends), connectivity = read_array_header(points);
  if (offsets.type == VTK_STRING || connectivity.type == VTK_STRING)
    throw DamagedFile(std::string(group->GetName()) + " of texts");
  std::vector<unsigned char> values = read(file, offsets, cells);
  const auto numbers = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(offsets.type));
  numbers->SetVoidArray(values.data(), static_cast<vtkIdType>(cells), 1);
  double end = 0;
  for (std::uint64_t k = 0; k < cells; ++k) {
    const double next = numbers->GetTuple1(static_cast<vtkIdType>(k));
    if (!(next >= end && next < 1e15))
      throw DamagedFile("offsets that do not rise: " + std::string(group->GetName()));
    end = next;
  }
  read(file, connectivity, static_cast<std::uint64_t>(end));
}

void check_piece(VtpArrays& file, vtkXMLDataElement* piece) {
  static constexpr std::array<const char*, 4> groups{"Verts", "Lines", "Strips", "Polys"};
  const std::uint64_t points = count_attribute(piece, "NumberOfPoints");
  std::array<std::uint64_t, 4> cells{};
  std::uint64_t all_cells = 0;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    cells[k] = count_attribute(piece, (std::string("NumberOf") + groups[k]).c_str());
    all_cells += cells[k];
  }
  for_each_nested(piece, [&](vtkXMLDataElement* group) {
    if (has_name(group, "PointData"))
      check_attributes(file, group, points);
    else if (has_name(group, "CellData"))
      check_attributes(file, group, all_cells);
    else if (has_name(group, "Points"))
      for_each_nested(group, [&](vtkXMLDataElement* element) {
        const ArrayHeader a = read_array_header(element);
        if (a.type == VTK_STRING || a.components != 3)
          throw DamagedFile("points that are not of three numbers");
        read(file, a, points);
      });
    for (std::size_t k = 0; k < groups.size(); ++k)
      if (has_name(group, groups[k]))
        check_cells(file, group, cells[k]);
  });
}

void refuse_time_steps(vtkXMLDataElement* element) {
  if (element->GetAttribute("TimeStep") || element->GetAttribute("TimeValues"))
    throw DamagedFile("several time steps in one file");
  for_each_nested(element, refuse_time_steps);
}

void check_elements(VtpArrays& file) {
  vtkXMLDataElement* root = file.GetRootElement();
  refuse_time_steps(root);
  int pieces = 0;
  for_each_nested(root, [&](vtkXMLDataElement* data) {
    if (has_name(data, "PolyData"))
      for_each_nested(data, [&](vtkXMLDataElement* element) {
        if (has_name(element, "Piece")) {
          ++pieces;
          check_piece(file, element);
        }
        if (has_name(element, "FieldData"))
          for_each_nested(element, [&](vtkXMLDataElement* array) {
            read(file, read_array_header(array), count_attribute(array, "NumberOfTuples"));
          });
      });
  });
  if (pieces == 0)
    throw DamagedFile("no piece of polydata");
}

} // namespace

void check_vtp(const std::filesystem::path& file, const std::string& what) {
  std::ifstream stream(file, std::ios::binary);
  vtkNew<VtpArrays> arrays;
  try {
    arrays->parse(stream, std::filesystem::file_size(file));
    check_elements(*arrays);
  } catch (const DamagedFile& e) {
    throw InputError("the " + what + " cannot be read", file.string(), e.what(),
                     "it is damaged, or of a form that is not read: write it anew");
  }
}

} // namespace common
