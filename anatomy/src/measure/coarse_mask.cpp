#include "measure/coarse_mask.hpp"

namespace anatomy {
namespace {

constexpr double lost_voxels = 1.1; // a lumen this thin is a chain of voxels that touch at their corners only

} // namespace

void warn_of_few_voxels(const std::vector<Branch>& branches, const std::vector<Section>& sections, double voxel,
                        std::vector<Repair>& notes) {
  const Section* narrowest = nullptr;
  std::size_t count = 0;
  for (const Section& section : sections) {
    if (section.flag == "end" || section.equivalent_diameter() / 2 >= fewest_voxels * voxel)
      continue;
    ++count;
    if (!narrowest || section.area < narrowest->area)
      narrowest = &section;
  }
  if (!narrowest)
    return;
  const Branch& branch = branches[narrowest->branch];
  const double radius = narrowest->equivalent_diameter() / 2 / voxel;
  char detail[320];
  std::snprintf(
      detail, sizeof detail,
      "sections below %.0f voxels of %.3g mm in radius, the narrowest %.2f voxels on %s at %s: %s; segment an "
      "image of smaller voxels",
      fewest_voxels, voxel, radius, branch.name.c_str(), place(branch.x[narrowest->sample]).c_str(),
      radius < lost_voxels ? "areas there may be a third too small and more"
                           : "single areas there may be wrong by up to a quarter");
  notes.push_back({"lumen of few voxels", count, detail, true});
}

} // namespace anatomy
