#include "mask/islands.hpp"
#include "common/error.hpp"
#include <algorithm>
#include <set>
#include <vtkImageConnectivityFilter.h>
#include <vtkStaticPointLocator.h>

namespace anatomy {
namespace {

constexpr double vessel_length_voxels = 8; // a piece shorter than this (in longest voxel edges) is noise, not a vessel
constexpr std::size_t noise_voxels = 8;    // more voxels than this in cavities give a warning
constexpr int most_empty_slices = 3;       // up to this many count as not segmented; a larger gap separates two trees

using Voxel = std::array<int, 3>;

// Numbers the connected pieces of the voxels with values from `least` to `most`: 1 is the largest piece. Voxels of a
// piece are connected by common faces. Voxels with other values get 0.
vtkSmartPointer<vtkImageData> pieces_of(vtkImageData* indicator, double least = 0.5, double most = 2) {
  vtkNew<vtkImageConnectivityFilter> pieces;
  pieces->SetInputData(indicator);
  pieces->SetScalarRange(least, most);
  pieces->SetLabelModeToSizeRank();
  pieces->SetLabelScalarTypeToInt();
  pieces->Update();
  return pieces->GetOutput();
}

template <class Action> void for_each_voxel(vtkImageData* image, const Action& action) {
  const int* extent = image->GetExtent();
  for (int k = extent[4]; k <= extent[5]; ++k)
    for (int j = extent[2]; j <= extent[3]; ++j)
      for (int i = extent[0]; i <= extent[1]; ++i)
        action(Voxel{i, j, k});
}

int rank_at(vtkImageData* pieces, const Voxel& v) {
  return *static_cast<const int*>(pieces->GetScalarPointer(v[0], v[1], v[2]));
}

// Joins pieces that touch at a corner or an edge of their voxels only. The voxels of a path between them are filled.
// Returns the number of filled voxels. All neighbours exist, since the image has a margin round the label.
std::size_t join_corners(vtkImageData* indicator, vtkImageData* pieces) {
  std::size_t filled = 0;
  const auto fill = [&](const Voxel& v) {
    auto* value = static_cast<float*>(indicator->GetScalarPointer(v[0], v[1], v[2]));
    filled += *value < 0.5F;
    *value = 1;
  };
  for_each_voxel(pieces, [&](const Voxel& v) {
    const int rank = rank_at(pieces, v);
    if (rank == 0)
      return;
    for (int di = -1; di <= 1; ++di)
      for (int dj = -1; dj <= 1; ++dj)
        for (int dk = 0; dk <= 1; ++dk) { // dk = -1 would give the pairs of dk = 1 again
          const Voxel w{v[0] + di, v[1] + dj, v[2] + dk};
          const int other = rank_at(pieces, w);
          if (other == 0 || other == rank)
            continue;
          fill({w[0], v[1], v[2]});
          fill({w[0], w[1], v[2]});
        }
  });
  return filled;
}

struct Piece {
  std::vector<Voxel> voxels;
  double length = 0; // diagonal of its box, in the file's unit
};

Eigen::Vector3d in_file(const Mask& mask, const Voxel& v) {
  return (mask.to_file * Eigen::Vector4d(v[0], v[1], v[2], 1)).head<3>();
}

std::vector<Piece> list_pieces(vtkImageData* ranks, const Mask& mask) {
  std::vector<Piece> pieces;
  for_each_voxel(ranks, [&](const Voxel& v) {
    const auto rank = static_cast<std::size_t>(rank_at(ranks, v));
    if (rank == 0)
      return;
    pieces.resize(std::max(pieces.size(), rank));
    pieces[rank - 1].voxels.push_back(v);
  });
  for (Piece& piece : pieces) {
    Eigen::AlignedBox3d box;
    for (const Voxel& v : piece.voxels)
      box.extend(Eigen::Vector3d(v[0], v[1], v[2]));
    piece.length = (mask.to_file.topLeftCorner<3, 3>() * (box.sizes() + Eigen::Vector3d::Ones())).norm();
  }
  return pieces;
}

vtkSmartPointer<vtkStaticPointLocator> locator_of(const Piece& piece, const Mask& mask) {
  vtkNew<vtkPoints> points;
  for (const Voxel& v : piece.voxels)
    points->InsertNextPoint(in_file(mask, v).data());
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  auto locator = vtkSmartPointer<vtkStaticPointLocator>::New();
  locator->SetDataSet(data);
  locator->BuildLocator();
  return locator;
}

// The voxel of `piece` nearest to the kept piece, and its distance from that piece in the file's unit. `kept` finds
// points among the voxel centres of the kept piece.
std::pair<Voxel, double> nearest_to(vtkStaticPointLocator* kept, const Piece& piece, const Mask& mask) {
  std::pair<Voxel, double> best{piece.voxels.front(), 1e300};
  for (const Voxel& v : piece.voxels) {
    const Eigen::Vector3d p = in_file(mask, v);
    double q[3];
    kept->GetDataSet()->GetPoint(kept->FindClosestPoint(p.data()), q);
    if (const double away = (Eigen::Vector3d(q[0], q[1], q[2]) - p).norm(); away < best.second)
      best = {v, away};
  }
  return best;
}

std::size_t nearest_piece(const std::vector<Piece>& pieces, const Eigen::Vector3d& inlet, const Mask& mask) {
  std::size_t best = 0;
  double least = 1e300;
  for (std::size_t k = 0; k < pieces.size(); ++k)
    if (k == 0 || pieces[k].length >= vessel_length_voxels * longest_edge(mask))
      for (const Voxel& v : pieces[k].voxels)
        if (const double away = (in_file(mask, v) - inlet).norm(); away < least) {
          least = away;
          best = k;
        }
  return best;
}

// Throws InputError if one to three slices without the label lie between the kept piece and another piece as long as a
// vessel. The other piece must go on behind the slices where the kept one ends. Such slices were not segmented, so the
// gap is no end of the vessel.
void check_no_empty_slice(vtkImageData* ranks, const std::vector<Piece>& pieces, std::size_t kept, const Mask& mask) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::set<int> filled;
    for (const Piece& piece : pieces)
      for (const Voxel& v : piece.voxels)
        filled.insert(v[axis]);
    for (auto low = filled.begin(), high = std::next(low); high != filled.end(); low = high++) {
      const int empty = *high - *low - 1;
      if (empty == 0 || empty > most_empty_slices)
        continue;
      for (std::size_t k = 0; k < pieces.size(); ++k)
        for (Voxel v : pieces[k].voxels) {
          if (k == kept || pieces[k].length < vessel_length_voxels * longest_edge(mask) ||
              (v[axis] != *low && v[axis] != *high))
            continue;
          const std::string at = place_in_file(mask, Eigen::Vector4d(v[0], v[1], v[2], 1));
          v[axis] = v[axis] == *low ? *high : *low;
          if (rank_at(ranks, v) == static_cast<int>(kept) + 1)
            throw common::InputError("the vessel is cut by slices without its label", at,
                                     std::to_string(empty) + " empty, and " + std::to_string(pieces[k].voxels.size()) +
                                         " voxels of the vessel behind",
                                     "fill the slices from their neighbours in the mask; to use one part alone, clear "
                                     "the other");
        }
    }
  }
}

} // namespace

std::string place_in_file(const Mask& mask, const Eigen::Vector4d& voxel) {
  const Eigen::Vector4d p = mask.to_file * voxel;
  char text[96];
  std::snprintf(text, sizeof text, "(%.5g, %.5g, %.5g) in the file's own unit", p.x(), p.y(), p.z());
  return text;
}

double longest_edge(const Mask& mask) {
  return mask.to_file.topLeftCorner<3, 3>().colwise().norm().maxCoeff();
}

void keep_one_island(vtkImageData* indicator, const Mask& mask, const std::optional<Vec3>& inlet,
                     std::vector<Repair>& repairs) {
  vtkSmartPointer<vtkImageData> ranks = pieces_of(indicator);
  if (const std::size_t filled = join_corners(indicator, ranks); filled > 0) {
    repairs.push_back({"voxels filled where the label touches itself by corners only", filled, ""});
    ranks = pieces_of(indicator);
  }
  const std::vector<Piece> pieces = list_pieces(ranks, mask);
  if (pieces.size() < 2)
    return;
  const std::size_t kept = inlet ? nearest_piece(pieces, *inlet, mask) : 0;
  check_no_empty_slice(ranks, pieces, kept, mask);
  const auto locator = locator_of(pieces[kept], mask);
  std::size_t dropped = 0;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const Piece& piece = pieces[k];
    if (k == kept)
      continue;
    dropped += piece.voxels.size();
    for (const Voxel& v : piece.voxels)
      *static_cast<float*>(indicator->GetScalarPointer(v[0], v[1], v[2])) = 0;
    if (piece.length < vessel_length_voxels * longest_edge(mask))
      continue;
    const auto [voxel, away] = nearest_to(locator, piece, mask);
    char text[320];
    std::snprintf(text, sizeof text,
                  "%zu voxels, %.3g long, the kept piece has %zu voxels; it is %.3g from it at %s. If both are one "
                  "vessel, fill the gap in the mask; if it is another tree, --inlet in it chooses it",
                  piece.voxels.size(), piece.length, pieces[kept].voxels.size(), away,
                  place_in_file(mask, Eigen::Vector4d(voxel[0], voxel[1], voxel[2], 1)).c_str());
    repairs.push_back({"another vessel left out", 1, text, true});
  }
  repairs.push_back(
      {"islands of the mask dropped", pieces.size() - 1,
       std::to_string(dropped) + " voxels; kept the " + (inlet ? "one nearest to the inlet" : "largest")});
}

void fill_cavities(vtkImageData* indicator, const Mask& mask, std::vector<Repair>& repairs) {
  const vtkSmartPointer<vtkImageData> ranks = pieces_of(indicator, -1, 0.5);
  const int* extent = indicator->GetExtent();
  const int outside = rank_at(ranks, {extent[0], extent[2], extent[4]}); // the first voxel lies in the margin
  std::size_t filled = 0;
  Voxel last{};
  for_each_voxel(ranks, [&](const Voxel& v) {
    if (const int rank = rank_at(ranks, v); rank == 0 || rank == outside)
      return;
    *static_cast<float*>(indicator->GetScalarPointer(v[0], v[1], v[2])) = 1;
    ++filled;
    last = v;
  });
  if (filled == 0)
    return;
  const std::string at = place_in_file(mask, Eigen::Vector4d(last[0], last[1], last[2], 1));
  repairs.push_back({"cavities of the mask filled", filled,
                     std::to_string(filled) + " voxels that the label encloses, one at " + at +
                         ". They count as blood; open a cavity of calcium at the wall to the outside in the mask",
                     filled > noise_voxels});
}

} // namespace anatomy
