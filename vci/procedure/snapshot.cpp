#include "vci/procedure/snapshot.hpp"

namespace vci {

namespace {

Vectors spread(const RunState& run, const Vectors& of_wall) {
  Vectors all(of_wall.empty() ? 0 : run.lumen.points.size(), Vec3::Zero());
  for (std::size_t i = 0; i < run.wall.vertex.size() && !all.empty(); ++i)
    all[run.wall.vertex[i]] = of_wall[i];
  return all;
}

Vectors part(const Vectors& all, const Body& body) {
  const auto first = all.begin() + body.first;
  return all.empty() ? Vectors{} : Vectors(first, first + body.count);
}

} // namespace

Balance on_lumen(const RunState& run, const Balance& b) {
  return {spread(run, b.pressure), spread(run, b.contact), spread(run, b.foundation), spread(run, b.residual)};
}

DeviceShape shape_of(const RunState& run, int index, const std::string& name, const Balance& b) {
  const Body& body = run.system.body(index);
  DeviceShape shape{run.is_stent(index) ? DeviceShape::Kind::stent : DeviceShape::Kind::balloon,
                    name,
                    part(run.system.x, body),
                    body.triangles,
                    {part(b.pressure, body), part(b.contact, body), part(b.foundation, body), part(b.residual, body)}};
  for (Triangle& t : shape.triangles)
    for (int& v : t)
      v -= body.first;
  return shape;
}

Snapshot snapshot_of(const RunState& run, int stages_done, int steps, const Balance& forces) {
  Snapshot snapshot{stages_done, steps, run.lumen_now(), on_lumen(run, forces), {}};
  for (int b = 1; b < run.system.bodies(); ++b)
    snapshot.devices.push_back(shape_of(run, b, run.system.body(b).name, forces));
  return snapshot;
}

} // namespace vci
