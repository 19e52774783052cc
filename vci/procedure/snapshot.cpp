#include "vci/procedure/snapshot.hpp"

namespace vci {

namespace {

Vectors spread_to_lumen(const RunState& run, const Vectors& of_wall) {
  Vectors all(of_wall.empty() ? 0 : run.lumen.points.size(), Vec3::Zero());
  for (std::size_t i = 0; i < run.wall.lumen_vertex.size() && !all.empty(); ++i)
    all[run.wall.lumen_vertex[i]] = of_wall[i];
  return all;
}

Vectors body_part(const Vectors& all, const Body& body) {
  const auto first = all.begin() + body.first;
  return all.empty() ? Vectors{} : Vectors(first, first + body.count);
}

} // namespace

Balance forces_on_lumen(const RunState& run, const Balance& b) {
  return {spread_to_lumen(run, b.pressure), spread_to_lumen(run, b.contact), spread_to_lumen(run, b.foundation),
          spread_to_lumen(run, b.residual)};
}

DeviceShape shape_of(const RunState& run, int index, const std::string& name, const Balance& b) {
  const Body& body = run.system.body(index);
  DeviceShape shape{run.is_stent(index) ? DeviceShape::Kind::stent : DeviceShape::Kind::balloon,
                    name,
                    body_part(run.system.x, body),
                    body.triangles,
                    {body_part(b.pressure, body), body_part(b.contact, body), body_part(b.foundation, body),
                     body_part(b.residual, body)}};
  for (Triangle& t : shape.triangles)
    for (int& v : t)
      v -= body.first;
  return shape;
}

Snapshot snapshot_of(const RunState& run, int stages_done, int steps, const Balance& forces) {
  Snapshot snapshot{stages_done, steps, run.current_lumen(), forces_on_lumen(run, forces), {}};
  for (int b = 1; b < run.system.bodies(); ++b)
    snapshot.devices.push_back(shape_of(run, b, run.system.body(b).name, forces));
  return snapshot;
}

} // namespace vci
