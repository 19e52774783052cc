#include "measure/coarse_mask.hpp"
#include <algorithm>

namespace anatomy {
namespace {

// Limits of a lumen's radius, in voxel edges. Below lost_voxels (masks) or lost_smoothed (surfaces) the measured area
// depends on where the lumen lies on the grid (anatomy/measured.md). Below thread_voxels the error is larger still.
constexpr double lost_voxels = 1.1;   // such a lumen is a chain of voxels that touch at their corners only
constexpr double lost_smoothed = 1.5; // larger, as other programs' smoothing narrows the lumen by up to 0.3 voxels
constexpr double thread_voxels = 0.5; // a throat of 0.47 voxels in radius was measured as 0.24
// Possible error of a lumen's area, in per cent.
constexpr double thread_error = 75;     // for a radius below thread_voxels
constexpr double lost_error = 50;       // for a larger radius, up to lost_voxels or lost_smoothed
constexpr double few_voxels_error = 25; // for a still larger radius, up to fewest_voxels

// Possible error in per cent of an area (mm2); 0 if the voxels are small enough for it.
double area_error(double area, const Voxels& voxels) {
  const double radius = std::sqrt(area / pi);
  if (radius >= fewest_voxels * voxels.edge)
    return 0;
  if (radius < thread_voxels * voxels.edge)
    return thread_error;
  return radius < (voxels.from_mask ? lost_voxels : lost_smoothed) * voxels.edge ? lost_error : few_voxels_error;
}

} // namespace

void note_few_voxels(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                     const std::vector<Lesion>& lesions, const Voxels& voxels, std::vector<Repair>& notes) {
  const Section* narrowest = nullptr;
  std::size_t count = 0, measured = 0;
  for (const Section& section : sections) {
    measured += section.flag != SectionFlag::end;
    if (section.flag == SectionFlag::end || area_error(section.area, voxels) == 0)
      continue;
    ++count;
    if (!narrowest || section.area < narrowest->area)
      narrowest = &section;
  }
  if (!narrowest)
    return;
  const Branch& branch = branches[narrowest->branch];
  char detail[400];
  std::snprintf(detail, sizeof detail,
                "sections below %.0f voxels of %.3g mm in radius, the narrowest %.2f voxels on %s at %s: single areas "
                "there may be wrong by up to %.0f %%; %s",
                fewest_voxels, voxels.edge, narrowest->equivalent_diameter() / 2 / voxels.edge, branch.name.c_str(),
                point_text(branch.x[narrowest->sample]).c_str(), area_error(narrowest->area, voxels),
                voxels.from_mask ? "segment an image of smaller voxels"
                                 : "the surface was contoured on a grid of that spacing; if that was a segmented "
                                   "image's, give the labels themselves or an image of smaller voxels");
  const bool lesion = std::any_of(lesions.begin(), lesions.end(), [](const Lesion& l) { return l.mla_error > 0; });
  notes.push_back({"lumen of few voxels", count, detail, lesion || 2 * count > measured});
}

std::string area_error_line(const Voxels& voxels) {
  if (voxels.edge == 0)
    return "";
  char line[200];
  std::snprintf(line, sizeof line, "%s of %.3g mm: areas of a lumen below %.2g mm in radius may be wrong by %.0f %%\n",
                voxels.from_mask ? "voxels" : "contoured on a grid", voxels.edge, fewest_voxels * voxels.edge,
                few_voxels_error);
  return line;
}

void set_area_errors(std::vector<Lesion>& lesions, const Voxels& voxels) {
  for (Lesion& lesion : lesions)
    lesion.mla_error = area_error(lesion.mla, voxels);
}

} // namespace anatomy
