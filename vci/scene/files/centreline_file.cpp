#include "vci/scene/files/centreline_file.hpp"
#include "common/error.hpp"
#include "vci/scene/files/reading.hpp"

#include <algorithm>
#include <set>
#include <sstream>
#include <vtkAbstractArray.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkStringArray.h>

namespace vci {

namespace {

/// Refuses a line that doubles back: its points are out of order, so its arc lengths are meaningless.
void refuse_turning_back(const Vectors& points, const std::string& name, const std::string& file) {
  // Cosine of the largest turn allowed (134 degrees). Pieces below the length (mm) are not judged, as points may
  // scatter.
  constexpr double sharpest_cosine = -0.7, least_piece_length = 0.1;
  for (std::size_t k = 2; k < points.size(); ++k) {
    const Vec3 before = points[k - 1] - points[k - 2], after = points[k] - points[k - 1];
    const double lengths = before.norm() * after.norm();
    if (std::min(before.norm(), after.norm()) > least_piece_length && before.dot(after) < sharpest_cosine * lengths) {
      std::ostringstream place;
      place << "at (" << points[k - 1].transpose() << ") mm, its point " << k - 1;
      throw common::InputError("a branch of the centreline turns back on itself", file + ": branch " + name,
                               place.str(), "give its points in their order along the vessel");
    }
  }
}

double distance_to_line(const Vectors& line, const Vec3& p) {
  double nearest = 1e300;
  for (const Vec3& q : line)
    nearest = std::min(nearest, (p - q).norm());
  return nearest;
}

/// Refuses a side branch whose line runs the wrong way: it must start on its parent's axis, not end there.
void refuse_reversed_sides(const Vectors& main, const NamedLines& sides, const std::string& file) {
  // mm: a line starts on another line if its first point is at most this far from the other
  constexpr double start_tolerance = 0.5;
  for (const auto& [name, points] : sides) {
    double start = distance_to_line(main, points.front()), end = distance_to_line(main, points.back());
    for (const auto& [other, line] : sides)
      if (other != name) {
        start = std::min(start, distance_to_line(line, points.front()));
        end = std::min(end, distance_to_line(line, points.back()));
      }
    if (start > start_tolerance && end < start) {
      std::ostringstream value;
      value << "its first point is " << start << " mm from the other branches, its last " << end;
      throw common::InputError("a side branch of the centreline does not start at its parent",
                               file + ": branch " + name, value.str(),
                               "turn the branch round: it runs from its parent to its outlet");
    }
  }
}

Vectors points_of_line(vtkPolyData* data, vtkIdType line, const std::filesystem::path& file) {
  vtkIdType size;
  const vtkIdType* ids;
  data->GetLines()->GetCellAtId(line, size, ids);
  if (std::any_of(ids, ids + size, [&](vtkIdType id) { return id < 0 || id >= data->GetNumberOfPoints(); }))
    throw common::InputError("a cell that names a point which is not there", file.string(),
                             "cell " + std::to_string(line), "the file is damaged: write it anew");
  Vectors points(size);
  for (vtkIdType k = 0; k < size; ++k) {
    data->GetPoint(ids[k], points[k].data());
    points[k] = points[k].unaryExpr(&rounded_to_nanometre);
  }
  return points;
}

NamedLines named_lines(const std::filesystem::path& file) {
  const vtkSmartPointer<vtkPolyData> data = read_polydata(file, "centreline");
  auto* names = vtkStringArray::SafeDownCast(data->GetCellData()->GetAbstractArray("branch_name"));
  if (!names || data->GetNumberOfLines() == 0 || data->GetNumberOfLines() != data->GetNumberOfCells())
    throw common::InputError("the centreline has no named lines", file.string(), "branch_name",
                             "make the centreline with the anatomy step");
  NamedLines lines;
  for (vtkIdType c = 0; c < data->GetNumberOfLines(); ++c)
    lines.emplace_back(names->GetValue(c), points_of_line(data, c, file));
  return lines;
}

/// The points (mm) of a line without repeated points. Throws common::InputError for impossible points.
Vectors checked_line(const std::string& name, const Vectors& line, const std::string& file) {
  Vectors points;
  for (std::size_t k = 0; k < line.size(); ++k) {
    const Vec3& p = line[k];
    if (!p.allFinite() || p.norm() > 1e6)
      throw common::InputError("a point of the centreline is not plausible", file + ": branch " + name,
                               "point " + std::to_string(k), "coordinates are in mm");
    if (points.empty() || (p - points.back()).norm() > 1e-9)
      points.push_back(p);
  }
  if (points.size() < 2)
    throw common::InputError("a centreline branch has fewer than two points", file, name, "check the anatomy step");
  refuse_turning_back(points, name, file);
  return points;
}

/// A side branch's path from the inlet on: points of the parent branch, then those of the side branch. The parent is
/// the branch of `paths` whose axis is nearest to the side branch's first point.
Path joined_to_parent(const Vectors& points, const std::map<std::string, Path>& paths) {
  // mm: the parent's last points are left out if they are this near to the side branch's first point
  constexpr double joint_distance = 0.2;
  const Path* parent = nullptr;
  std::size_t leaving_index = 0;
  double nearest = 1e300;
  for (const auto& [other, path] : paths)
    for (std::size_t k = 0; k < path.points().size(); ++k)
      if (const double d = (path.points()[k] - points.front()).squaredNorm(); d < nearest) {
        nearest = d;
        parent = &path;
        leaving_index = k;
      }
  Vectors joined(parent->points().begin(), parent->points().begin() + static_cast<std::ptrdiff_t>(leaving_index));
  while (joined.size() > 1 && (joined.back() - points.front()).norm() < joint_distance)
    joined.pop_back();
  joined.insert(joined.end(), points.begin(), points.end());
  const std::size_t before = joined.size() - points.size();
  double upstream = 0;
  for (std::size_t k = 1; k <= before; ++k)
    upstream += (joined[k] - joined[k - 1]).norm();
  return Path(joined, -upstream);
}

} // namespace

std::map<std::string, Path> centreline_from(NamedLines lines, const std::string& where) {
  std::set<std::string> names;
  for (auto& [name, points] : lines) {
    points = checked_line(name, points, where);
    if (!names.insert(name).second)
      throw common::InputError("two branches of the centreline have one name", where, name,
                               "name each branch otherwise: devices are placed by it");
  }
  const auto main = std::find_if(lines.begin(), lines.end(), [](const auto& line) { return line.first == "main"; });
  if (main == lines.end())
    throw common::InputError("the centreline lacks its main branch", where, "main", "check the anatomy step");
  std::map<std::string, Path> paths{{"main", Path(main->second, 0)}};
  lines.erase(main);
  refuse_reversed_sides(paths.at("main").points(), lines, where);
  for (const auto& [name, points] : lines)
    paths[name] = joined_to_parent(points, paths);
  return paths;
}

std::map<std::string, Path> read_centreline(const std::filesystem::path& file) {
  return guarded_read(file, [&] { return centreline_from(named_lines(file), file.string()); });
}

} // namespace vci
