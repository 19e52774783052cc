#include "app/output.hpp"
#include "app/vtk_output.hpp"
#include "common/error.hpp"
#include <algorithm>
#include <filesystem>
#include <fstream>

namespace anatomy {
namespace {

nlohmann::ordered_json json_vector(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

// A section's flag as sections.csv has it.
const char* text_of(SectionFlag flag) {
  switch (flag) {
  case SectionFlag::ok:
    return "ok";
  case SectionFlag::ostium:
    return "ostium";
  case SectionFlag::end:
    break;
  }
  return "end";
}

std::string sections_csv(const Anatomy& anatomy) {
  std::string text = "branch,branch_id,s_mm,x_mm,y_mm,z_mm,tx,ty,tz,area_mm2,equivalent_diameter_mm,min_diameter_mm,"
                     "max_diameter_mm,inscribed_radius_mm,reference_diameter_mm,curvature_per_mm,torsion_per_mm,flag\n";
  for (const Section& section : anatomy.sections) {
    const Branch& branch = anatomy.branches[section.branch];
    const std::size_t i = section.sample;
    const Vec3 x = branch.x[i], t = branch.axis.tangent(branch.s[i]);
    char line[400];
    std::snprintf(line, sizeof line,
                  "%s,%d,%.4f,%.5f,%.5f,%.5f,%.6f,%.6f,%.6f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.6f,%.6f,%s\n",
                  branch.name.c_str(), branch.id, branch.s[i], x.x(), x.y(), x.z(), t.x(), t.y(), t.z(), section.area,
                  section.equivalent_diameter(), section.min_diameter, section.max_diameter, branch.radius[i],
                  anatomy.profiles[section.branch].diameter(branch.s[i]), branch.curvature[i], branch.torsion[i],
                  text_of(section.flag));
    text += line;
  }
  return text;
}

nlohmann::ordered_json branch_entry(const Anatomy& anatomy, const Branch& branch) {
  double mean = 0, highest = 0;
  // Next to a cap the axis has few points, so curvatures there do not count for the branch.
  std::size_t counted = 0;
  for (std::size_t i = 0; i < branch.s.size(); ++i) {
    if (is_near_end(branch, anatomy.ends, branch.s[i]) || (branch.parent >= 0 && branch.s[i] < branch.s_outside))
      continue;
    mean += branch.curvature[i];
    highest = std::max(highest, branch.curvature[i]);
    ++counted;
  }
  const double chord = (branch.x.back() - branch.x.front()).norm();
  nlohmann::ordered_json entry{{"name", branch.name}, {"branch_id", branch.id}};
  entry["parent"] = branch.parent < 0
                        ? nlohmann::ordered_json(nullptr)
                        : nlohmann::ordered_json(anatomy.branches[static_cast<std::size_t>(branch.parent)].name);
  entry["s_on_parent_mm"] = branch.s_on_parent;
  entry["length_mm"] = branch.axis.length();
  entry["end"] = anatomy.ends[branch.end].name;
  entry["mean_curvature_per_mm"] = counted ? mean / static_cast<double>(counted) : 0.0;
  entry["max_curvature_per_mm"] = highest;
  entry["tortuosity"] = branch.axis.length() / chord;
  return entry;
}

nlohmann::ordered_json lesion_entry(const Anatomy& anatomy, const Lesion& lesion, std::size_t number) {
  return {{"name", "lesion" + std::to_string(number)},
          {"branch", anatomy.branches[lesion.branch].name},
          {"s_start_mm", lesion.s_start},
          {"s_mla_mm", lesion.s_mla},
          {"s_end_mm", lesion.s_end},
          {"mla_mm2", lesion.mla},
          {"mla_error_percent", lesion.mla_error},
          {"mld_mm", lesion.mld},
          {"reference_diameter_mm", lesion.reference},
          {"proximal_reference_diameter_mm", lesion.proximal_reference},
          {"distal_reference_diameter_mm", lesion.distal_reference},
          {"diameter_stenosis_percent", lesion.diameter_stenosis},
          {"area_stenosis_percent", lesion.area_stenosis}};
}

} // namespace

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush())
    throw common::WriteError(path.string());
}

// The diameter (mm) of the circle with the area of the vessel's cross-section at an end. A slanted cap is larger than
// this cross-section, so its area is projected onto the plane perpendicular to the axis. The axis's direction is taken
// over its last piece at the end, which is as long as the end's radius.
double vessel_width_at(const End& end, const std::vector<Branch>& branches) {
  const Axis& axis =
      std::find_if(branches.begin(), branches.end(), [&](const Branch& one) { return one.name == end.branch; })->axis;
  const double last = std::min(end.radius(), axis.length());
  const Vec3 direction =
      end.inlet ? axis.at(last) - axis.at(0) : axis.at(axis.length()) - axis.at(axis.length() - last);
  return 2 * end.radius() * std::sqrt(std::abs(direction.normalized().dot(end.normal)));
}

nlohmann::ordered_json summary(const Anatomy& anatomy, const StepTimer& timer) {
  nlohmann::ordered_json out;
  out["schema"] = "vci-anatomy-1";
  out["source"] = {{"path", anatomy.source_path}, {"sha256", anatomy.source_sha256}, {"units", text_of(anatomy.unit)}};
  out["ends"] = nlohmann::ordered_json::array();
  std::vector<End> ends = anatomy.ends;
  std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) { return a.region < b.region; });
  for (const End& end : ends)
    out["ends"].push_back({{"name", end.name},
                           {"region_id", end.region},
                           {"kind", end.inlet ? "inlet" : "outlet"},
                           {"branch", end.branch},
                           {"centre_mm", json_vector(end.centre)},
                           {"normal", json_vector(end.normal)},
                           {"area_mm2", end.area},
                           {"diameter_mm", vessel_width_at(end, anatomy.branches)},
                           {"extension_mm", end.extension}});
  out["branches"] = nlohmann::ordered_json::array();
  for (const Branch& branch : anatomy.branches)
    out["branches"].push_back(branch_entry(anatomy, branch));
  out["lesions"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < anatomy.lesions.size(); ++i)
    out["lesions"].push_back(lesion_entry(anatomy, anatomy.lesions[i], i + 1));
  out["repairs"] = nlohmann::ordered_json::array();
  for (const Repair& repair : anatomy.repairs)
    out["repairs"].push_back(
        {{"what", repair.what}, {"count", repair.count}, {"detail", repair.detail}, {"warning", repair.warning}});
  out["mesh"] = {{"edge_mm", anatomy.edge},
                 {"smallest_edge_mm", anatomy.quality.smallest_edge_mm},
                 {"vertices", anatomy.mesh.number_of_vertices()},
                 {"triangles", anatomy.mesh.number_of_faces()},
                 {"min_angle_deg", anatomy.quality.min_angle_deg},
                 {"min_angle_at_rims_deg", anatomy.quality.min_angle_rim_deg},
                 {"volume_mm3", anatomy.quality.volume_mm3}};
  for (const auto& [step, seconds] : timer.seconds())
    out["timings_s"][step] = seconds;
  return out;
}

void write_anatomy(const Anatomy& anatomy, const StepTimer& timer, const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw common::InputError("the folder cannot be made", folder, error.message(), "name one that can be written");
  const std::vector<std::string> names{"lumen.vtp", "centreline.vtp", "sections.csv", "anatomy.json"};
  const auto partial = [&](const std::string& name) { return temporary_path(fs::path(folder) / name); };
  try {
    write_vtp(lumen_data(anatomy.mesh, &anatomy.arrays), partial(names[0]));
    write_vtp(centreline_data(anatomy.branches), partial(names[1]));
    write_text(partial(names[2]), sections_csv(anatomy));
    write_text(partial(names[3]), summary(anatomy, timer).dump(1) + "\n");
    for (const std::string& name : names)
      fs::rename(partial(name), fs::path(folder) / name);
  } catch (...) {
    for (const std::string& name : names)
      fs::remove(partial(name));
    throw;
  }
}

} // namespace anatomy
