#include "vci/results/strut_pattern.hpp"

#include <algorithm>
#include <cmath>

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkTriangleFilter.h>
#include <vtkTubeFilter.h>

namespace vci {

namespace {

/// Point (mm) of the deployed grid, at a share of its length (0 to 1) and a share of a turn round it.
/// @param x vertices of the grid, mm
Vec3 point_on_grid(const RingGrid& grid, const Vectors& x, double length_share, double turn_share) {
  const double r = std::clamp(length_share, 0.0, 1.0) * (grid.rings() - 1);
  const int r0 = std::min(static_cast<int>(r), grid.rings() - 2);
  double k = (turn_share - std::floor(turn_share)) * grid.ring_size;
  const int k0 = static_cast<int>(k) % grid.ring_size, k1 = (k0 + 1) % grid.ring_size;
  const double u = r - r0, v = k - std::floor(k);
  const auto at = [&](int ring, int place) { return x[ring * grid.ring_size + place]; };
  return (1 - u) * ((1 - v) * at(r0, k0) + v * at(r0, k1)) + u * ((1 - v) * at(r0 + 1, k0) + v * at(r0 + 1, k1));
}

/// Adds round tubes about the lines, of diameter `thickness` (mm) and closed at their ends.
void add_tubes(Struts& s, double thickness) {
  constexpr int sides = 6;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& p : s.points)
    points->InsertNextPoint(p.data());
  vtkNew<vtkCellArray> lines;
  for (const auto& line : s.lines) {
    lines->InsertNextCell(static_cast<int>(line.size()));
    for (int v : line)
      lines->InsertCellPoint(v);
  }
  vtkNew<vtkPolyData> axes;
  axes->SetPoints(points);
  axes->SetLines(lines);
  vtkNew<vtkTubeFilter> tubes;
  tubes->SetInputData(axes);
  tubes->SetRadius(0.5 * thickness);
  tubes->SetNumberOfSides(sides);
  tubes->CappingOn();
  tubes->SetOutputPointsPrecision(vtkAlgorithm::DOUBLE_PRECISION);
  vtkNew<vtkTriangleFilter> triangulated;
  triangulated->SetInputConnection(tubes->GetOutputPort());
  triangulated->Update();
  vtkPolyData* surface = triangulated->GetOutput();
  const int first = static_cast<int>(s.points.size());
  for (vtkIdType i = 0; i < surface->GetNumberOfPoints(); ++i)
    s.points.emplace_back(surface->GetPoint(i));
  vtkCellArray* polygons = surface->GetPolys();
  for (vtkIdType k = 0; k < surface->GetNumberOfPolys(); ++k) {
    vtkIdType size;
    const vtkIdType* ids;
    polygons->GetCellAtId(k, size, ids);
    s.triangles.push_back(
        {first + static_cast<int>(ids[0]), first + static_cast<int>(ids[1]), first + static_cast<int>(ids[2])});
  }
}

} // namespace

Struts strut_pattern(const StentSpec& spec, const RingGrid& grid, const Vectors& cylinder) {
  constexpr double row_length = 1.2; // mm of stent for each row of crowns with its links
  constexpr double row_share = 0.8;  // share of this length that the crowns take; links take the rest
  constexpr int points_per_strut = 6;
  const int rows = std::max(2, static_cast<int>(std::lround(spec.length / row_length)));
  Struts s;
  for (int row = 0; row < rows; ++row) {
    std::vector<int> line;
    const int n = 2 * spec.crowns * points_per_strut;
    for (int k = 0; k <= n; ++k) {
      const double turn = static_cast<double>(k) / n;
      const double swing = 0.5 - 0.5 * std::cos(2 * pi * spec.crowns * turn);
      line.push_back(static_cast<int>(s.points.size()));
      s.points.push_back(point_on_grid(grid, cylinder, (row + row_share * swing) / (rows - 1 + row_share), turn));
    }
    s.lines.push_back(line);
    for (int link = 0; row + 1 < rows && link < spec.links; ++link) {
      // A link goes from a crest of this row to a valley of the next. From row to row the links move by one crown.
      const int crown = (link * spec.crowns / spec.links + row) % spec.crowns;
      const double from = (crown + 0.5) / spec.crowns, to = (crown + 1.0) / spec.crowns;
      std::vector<int> bridge;
      for (int k = 0; k <= 3; ++k) {
        const double t = k / 3.0;
        bridge.push_back(static_cast<int>(s.points.size()));
        const double place = (1 - t) * (row + row_share) + t * (row + 1.0);
        s.points.push_back(point_on_grid(grid, cylinder, place / (rows - 1 + row_share), (1 - t) * from + t * to));
      }
      s.lines.push_back(bridge);
    }
  }
  add_tubes(s, spec.strut_thickness);
  return s;
}

} // namespace vci
