// The mechanical system: bodies, their vertices and forces. Bodies are stacked; the last one can be taken out again.
#pragma once
#include "vci/mechanics/force.hpp"
#include <memory>
#include <string>

namespace vci {

/// A surface whose vertices are [first, first + count) of the system; triangles hold system-wide indices.
struct Body {
  std::string name;
  int first, count;
  Triangles triangles;
  std::vector<char> boundary; ///< per vertex: on an open edge of the surface
};

class System {
public:
  /// Adds a body; positions in mm, surface density in g/mm^2. Returns its index.
  int add_body(const std::string& name, const Vectors& positions, Triangles triangles, double surface_density,
               const std::vector<char>& fixed);
  /// Adds a force that belongs to a body and is removed with it.
  template <class F> F& add_force(int body, std::unique_ptr<F> force) {
    F& reference = *force;
    forces_.push_back({body, std::move(force)});
    linked_ = false;
    return reference; // cppcheck-suppress returnReference ; the force lives in forces_
  }
  /// Takes out the last body, its vertices and its forces.
  void remove_last_body();

  const Body& body(int k) const { return bodies_[k]; }
  int bodies() const { return static_cast<int>(bodies_.size()); }
  int vertices() const { return static_cast<int>(x.size()); }

  /// The matrix with the pattern of all current forces, built when needed.
  BlockMatrix& matrix();
  /// Force sums by kind (each sized to the vertices) and, if wanted, the stiffness matrix.
  void evaluate(Vectors& elastic, Vectors& foundation, Vectors& pressure, bool with_stiffness);
  void commit();
  /// Adds rate (1/ms) times the forces' damping to the matrix.
  void add_damping(double rate);

  Vectors x, velocity;      ///< mm, mm/ms
  std::vector<double> mass; ///< g
  std::vector<double> area; ///< mm^2 at the start
  std::vector<char> fixed;

private:
  struct Entry {
    int body;
    std::unique_ptr<Force> force;
  };
  std::vector<Body> bodies_;
  std::vector<Entry> forces_;
  BlockMatrix matrix_;
  bool linked_ = false;
};

} // namespace vci
