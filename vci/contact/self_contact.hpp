// Contact of a surface with itself: layers that lie on one another.
#pragma once
#include "vci/contact/contact.hpp"

namespace vci {

/// Each vertex may touch one layer on its outer side and one on its inner side. Both face it with opposing normals. The
/// side is decided when a layer comes within reach, and kept while the projection follows the surface. A vertex that
/// has passed through is therefore pushed back, and faces no other layer meanwhile. Triangles within an edge of the
/// vertex along the surface are its own layer. There is no friction, since balloons are coated.
class SelfContact {
public:
  /// @param stiffness of contact between two surfaces, MPa/mm, shared by the two layers
  /// @param thickness of the layer at each vertex, mm: contact begins at 0.9 of it; 0: the vertex touches nothing
  SelfContact(const System& system, int body, double stiffness, std::vector<double> thickness);
  int body() const { return body_; }
  /// Appends the active contact points at the system's positions. @param normals area vectors of all vertices
  void detect(const System& system, const Vectors& normals, std::vector<ContactPoint>& points);
  /// Vertices that some layer faces, after the last call.
  int facing() const;

private:
  struct Layer {
    int triangle = -1;        ///< the one that the vertex faces; -1: none
    Vec3 slip = Vec3::Zero(); ///< stays 0 without friction; every contact point needs one
    Vec3 weights = Vec3::Zero();
    double distance = 0, gap = 0; ///< mm; the gap is negative once the vertex is through
  };
  bool own(int vertex, const Triangle& t, int first) const;
  void follow(const System& system, int vertex, Layer& layer) const;
  bool keeps(const System& system, int vertex, double side, Layer& layer) const;
  void search(const System& system, int vertex, std::vector<NearTriangle>& found);
  void press(const System& system, int vertex, double area, double side, Layer& layer,
             std::vector<ContactPoint>& points) const;
  bool may_have_missed(const System& system);

  int body_;
  double stiffness_;
  std::vector<double> thickness_;
  std::array<std::vector<Layer>, 2> layers_; ///< of each vertex on its outer and its inner side
  std::vector<std::vector<int>> near_;       ///< per vertex: itself and its neighbours along edges, ascending
  std::vector<std::vector<int>> around_;     ///< per triangle: the triangles that share a vertex with it
  std::unique_ptr<BroadPhase> boxes_;
  Vectors units_, last_; ///< unit normals; positions at the last call
  double travel_ = 0;    ///< sum of the largest displacements since the last search, mm
};

} // namespace vci
