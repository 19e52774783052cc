// The mechanical system: bodies, their vertices and forces. The vertices of all bodies follow one another in one list,
// so only the last body can be taken out again.
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
  /// Adds a body and returns its number.
  /// @param positions positions of the vertices, mm
  /// @param triangles indices into `positions`
  /// @param surface_density g/mm^2
  /// @param fixed whether each vertex is held in place
  int add_body(const std::string& name, const Vectors& positions, Triangles triangles, double surface_density,
               const std::vector<char>& fixed);
  /// Adds a force that belongs to a body and is removed with it.
  template <class F> F& add_force(int body, std::unique_ptr<F> force) {
    F& reference = *force;
    forces_.push_back({body, std::move(force)});
    blocks_located_ = false;
    return reference; // cppcheck-suppress returnReference ; the force lives in forces_
  }
  /// Takes out the last body, its vertices and its forces.
  void remove_last_body();

  const Body& body(int k) const { return bodies_[k]; }
  int bodies() const { return static_cast<int>(bodies_.size()); }
  int vertices() const { return static_cast<int>(x.size()); }

  /// The stiffness matrix, with blocks for all pairs of vertices that interact. It is rebuilt after bodies or forces
  /// were added or removed.
  BlockMatrix& matrix();
  /// Sets the three sums of forces (N per vertex) by their kind and, if wanted, the stiffness matrix.
  void evaluate(Vectors& elastic, Vectors& foundation, Vectors& pressure, bool with_stiffness);
  /// Makes the plastic flow of all forces at the current positions permanent.
  void commit();
  /// Whether the displacements dx (mm) turn plastic flow back, see Force::stop_reversed_flow().
  bool stop_reversed_flow(const Vectors& dx);
  /// Adds rate (1/ms) times the forces' damping to the matrix.
  void add_damping(double rate);

  Vectors x, velocity;      ///< mm, mm/ms
  std::vector<double> mass; ///< g
  std::vector<double> area; ///< of each vertex when its body was added, mm^2
  std::vector<char> fixed;  ///< whether a vertex is held in place

private:
  struct BodyForce {
    int body;
    std::unique_ptr<Force> force;
  };
  std::vector<Body> bodies_;
  std::vector<BodyForce> forces_;
  BlockMatrix matrix_;
  bool blocks_located_ = false;
};

} // namespace vci
