#include "vci/mechanics/system.hpp"
#include "vci/geometry/surface.hpp"

namespace vci {

int System::add_body(const std::string& name, const Vectors& positions, Triangles triangles, double surface_density,
                     const std::vector<char>& fixed_flags) {
  const int first = vertices(), count = static_cast<int>(positions.size());
  const std::vector<char> boundary = boundary_vertices(triangles, count);
  std::vector<double> areas(count, 0.0);
  for (const Triangle& t : triangles)
    for (int v : t)
      areas[v] += area_vector(t, positions).norm() / 3.0;
  for (Triangle& t : triangles)
    for (int& v : t)
      v += first;
  x.insert(x.end(), positions.begin(), positions.end());
  velocity.resize(x.size(), Vec3::Zero());
  area.insert(area.end(), areas.begin(), areas.end());
  fixed.insert(fixed.end(), fixed_flags.begin(), fixed_flags.end());
  for (double a : areas)
    mass.push_back(a * surface_density);
  bodies_.push_back({name, first, count, std::move(triangles), boundary});
  blocks_located_ = false;
  return bodies() - 1;
}

void System::remove_last_body() {
  const int last = bodies() - 1, first = bodies_[last].first;
  std::erase_if(forces_, [&](const BodyForce& e) { return e.body == last; });
  bodies_.pop_back();
  x.resize(first);
  velocity.resize(first);
  mass.resize(first);
  area.resize(first);
  fixed.resize(first);
  blocks_located_ = false;
}

BlockMatrix& System::matrix() {
  if (!blocks_located_) {
    BlockPattern pattern(vertices());
    for (const BodyForce& e : forces_)
      e.force->declare_stencils(pattern);
    matrix_ = BlockMatrix(std::move(pattern));
    for (const BodyForce& e : forces_)
      e.force->locate_blocks(matrix_);
    blocks_located_ = true;
  }
  return matrix_;
}

void System::evaluate(Vectors& elastic, Vectors& foundation, Vectors& pressure, bool with_stiffness) {
  BlockMatrix* stiffness = with_stiffness ? &matrix() : nullptr;
  if (stiffness)
    stiffness->set_zero();
  for (Vectors* f : {&elastic, &foundation, &pressure})
    f->assign(x.size(), Vec3::Zero());
  for (const BodyForce& e : forces_) {
    const ForceKind kind = e.force->kind();
    Vectors& sum = kind == ForceKind::elastic ? elastic : kind == ForceKind::foundation ? foundation : pressure;
    e.force->evaluate(x, sum, stiffness, false);
  }
}

void System::add_damping(double rate) {
  for (const BodyForce& e : forces_)
    e.force->add_damping(x, mass, rate, matrix());
}

void System::commit() {
  for (const BodyForce& e : forces_)
    e.force->commit(x);
}

bool System::stop_reversed_flow(const Vectors& dx) {
  bool stopped = false;
  for (const BodyForce& e : forces_)
    stopped |= e.force->stop_reversed_flow(x, dx);
  return stopped;
}

} // namespace vci
