// One interface to CGAL 5.5 (Debian 12) and 6.0 (Debian 13).
#pragma once
#include <CGAL/version.h>
#include <string>

namespace anatomy {

/// Returns the mesh's property map with this name, which must exist.
template <class Map, class Mesh> Map existing_map(const Mesh& mesh, const std::string& name) {
  const auto found = mesh.template property_map<typename Map::key_type, typename Map::value_type>(name);
#if CGAL_VERSION_NR < 1060000000
  return found.first;
#else
  return found.value();
#endif
}

} // namespace anatomy
