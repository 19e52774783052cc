#include "repair/weld.hpp"
#include <algorithm>
#include <numeric>
#include <set>
#include <vtkBoundingBox.h>
#include <vtkPointLocator.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>

namespace anatomy {
namespace {

void keep_triangles(Soup& soup, const std::vector<bool>& keep) {
  std::size_t n = 0;
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    if (!keep[t])
      continue;
    soup.triangles[n] = soup.triangles[t];
    if (!soup.region.empty())
      soup.region[n] = soup.region[t];
    ++n;
  }
  soup.triangles.resize(n);
  if (!soup.region.empty())
    soup.region.resize(n);
}

void report(std::vector<Repair>& repairs, const std::string& what, std::size_t count, const std::string& detail = "") {
  if (count > 0)
    repairs.push_back({what, count, detail});
}

} // namespace

Soup welded(const Soup& soup, double tolerance, std::vector<Repair>& repairs) {
  vtkBoundingBox box;
  for (const Point& p : soup.points)
    box.AddPoint(p.x(), p.y(), p.z());
  double bounds[6] = {0, 0, 0, 0, 0, 0};
  if (box.IsValid())
    box.GetBounds(bounds);
  // Points are merged one after another, because vtkStaticPointLocator::MergePoints, which uses threads, sometimes
  // leaves points unmerged (VTK 9.1).
  auto locator = vtkSmartPointer<vtkPointLocator>::New();
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  locator->SetTolerance(tolerance);
  locator->InitPointInsertion(points, bounds, static_cast<vtkIdType>(soup.points.size()));
  std::vector<std::size_t> first; // for each welded point, the first of the points merged into it
  std::vector<std::size_t> merged(soup.points.size());
  for (std::size_t i = 0; i < soup.points.size(); ++i) {
    const double p[3] = {soup.points[i].x(), soup.points[i].y(), soup.points[i].z()};
    vtkIdType id = 0;
    if (locator->InsertUniquePoint(p, id))
      first.push_back(i);
    merged[i] = first[static_cast<std::size_t>(id)];
  }

  Soup out;
  out.region = soup.region;
  constexpr std::size_t unused = static_cast<std::size_t>(-1);
  std::vector<std::size_t> number(soup.points.size(), unused);
  for (const Triangle& t : soup.triangles) {
    Triangle corners;
    for (int k = 0; k < 3; ++k) {
      const std::size_t root = merged[t[static_cast<std::size_t>(k)]];
      if (number[root] == unused) {
        number[root] = out.points.size();
        out.points.push_back(soup.points[root]);
      }
      corners[static_cast<std::size_t>(k)] = number[root];
    }
    out.triangles.push_back(corners);
  }
  std::set<std::size_t> used;
  for (const Triangle& t : soup.triangles)
    used.insert(t.begin(), t.end());
  report(repairs, "points welded", used.size() - out.points.size());
  return out;
}

void drop_degenerate_and_duplicate(Soup& soup, std::vector<Repair>& repairs) {
  std::vector<bool> keep(soup.triangles.size(), true);
  std::set<Triangle> seen;
  std::size_t degenerate = 0, duplicate = 0;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    Triangle t = soup.triangles[i];
    std::sort(t.begin(), t.end());
    if (t[0] == t[1] || t[1] == t[2]) {
      keep[i] = false;
      ++degenerate;
    } else if (!seen.insert(t).second) {
      keep[i] = false;
      ++duplicate;
    }
  }
  keep_triangles(soup, keep);
  report(repairs, "degenerate triangles dropped", degenerate);
  report(repairs, "duplicate triangles dropped", duplicate);
}

void drop_fins(Soup& soup, std::vector<Repair>& repairs) {
  std::size_t dropped = 0;
  for (;;) {
    std::map<std::pair<std::size_t, std::size_t>, int> uses;
    const auto edge = [](const Triangle& t, std::size_t k) { return std::minmax(t[k], t[(k + 1) % 3]); };
    for (const Triangle& t : soup.triangles)
      for (std::size_t k = 0; k < 3; ++k)
        ++uses[edge(t, k)];
    if (std::none_of(uses.begin(), uses.end(), [](const auto& use) { return use.second > 2; }))
      break;
    std::vector<bool> keep(soup.triangles.size(), true);
    std::size_t now = 0;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
      bool free_edge = false, crowded_edge = false;
      for (std::size_t k = 0; k < 3; ++k) {
        const int n = uses[edge(soup.triangles[i], k)];
        free_edge |= n == 1;
        crowded_edge |= n > 2;
      }
      if (free_edge && crowded_edge) {
        keep[i] = false;
        ++now;
      }
    }
    if (now == 0)
      break;
    keep_triangles(soup, keep);
    dropped += now;
  }
  report(repairs, "fins dropped", dropped, "triangles that hang on an edge of the wall by one side");
}

} // namespace anatomy
