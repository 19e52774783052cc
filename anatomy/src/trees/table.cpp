#include "trees/table.hpp"

namespace anatomy {

std::string table_of(const std::vector<TreeEntry>& trees, const std::optional<Aorta>& aorta) {
  if (!aorta)
    return "";
  char line[240];
  std::snprintf(line, sizeof line, "an aorta %.1f mm wide at %s with %zu coronary %s\n", aorta->diameter,
                point_text(aorta->centre).c_str(), aorta->trees.size(), aorta->trees.size() == 1 ? "tree" : "trees");
  std::string text = line;
  text += "tree    ostium: x        y        z  diameter  length  outlets\n";
  for (const auto& [tree, outlets] : trees) {
    std::snprintf(line, sizeof line, "%-7s %9.2f %8.2f %8.2f %9.2f %7.0f %8zu\n", tree.name.c_str(),
                  tree.ostium.centre.x(), tree.ostium.centre.y(), tree.ostium.centre.z(), tree.diameter, tree.length,
                  outlets);
    text += line;
  }
  if (trees.size() > 1)
    text += aorta->unnamed_reason.empty()
                ? "choose one by --tree left or --tree right\n"
                : "choose one by --ostium x,y,z; left and right are not certain: " + aorta->unnamed_reason + "\n";
  return text;
}

nlohmann::ordered_json document_of(const std::vector<TreeEntry>& trees) {
  auto list = nlohmann::ordered_json::array();
  for (const auto& [tree, outlets] : trees) {
    const Vec3& at = tree.ostium.centre;
    list.push_back({{"name", tree.name},
                    {"ostium_mm", {at.x(), at.y(), at.z()}},
                    {"diameter_mm", tree.diameter},
                    {"length_mm", tree.length},
                    {"outlets", outlets}});
  }
  return list;
}

} // namespace anatomy
