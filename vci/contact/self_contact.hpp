// Contact of a folded surface with itself, where its layers lie on one another.
#pragma once
#include "vci/contact/contact.hpp"

namespace vci {

/// Each vertex may touch one layer on its outer side and one on its inner side. A layer counts if its normal and the
/// vertex's normal point opposite ways. The side is decided when the layer comes within reach. The side is kept while
/// the vertex's closest point moves along that layer. So a vertex that has passed through a layer is pushed back; until
/// then it meets no other layer on that side. Triangles that contain the vertex or one of its neighbours belong to the
/// vertex's own layer. There is no friction, since balloons are coated.
class SelfContact {
public:
  /// @param stiffness contact stiffness of two surfaces, MPa/mm; each of the two layers in touch gets half
  /// @param thickness thickness of the layer at each vertex, mm. Contact begins at a gap of 0.9 thicknesses. A vertex
  /// with 0 touches nothing.
  SelfContact(const System& system, int body, double stiffness, std::vector<double> thickness);
  int body() const { return body_; }
  /// Appends the active contact points at the system's positions.
  /// @param normals area vectors of all vertices
  void detect(const System& system, const Vectors& normals, std::vector<ContactPoint>& points);
  /// Number of vertices that face a layer, as found by the last detect().
  int count_facing() const;

private:
  struct FacedLayer {
    int triangle = -1;            ///< the triangle that the vertex faces; -1: none
    Vec3 slip = Vec3::Zero();     ///< always 0, since there is no friction; a ContactPoint needs it
    Vec3 weights = Vec3::Zero();  ///< barycentric weights of the triangle's point closest to the vertex
    double distance = 0, gap = 0; ///< mm; the gap is negative once the vertex has passed through the layer
  };
  bool in_own_layer(int vertex, const Triangle& t, int first) const;
  void follow_layer(const System& system, int vertex, FacedLayer& layer) const;
  bool still_faces(const System& system, int vertex, double side, FacedLayer& layer) const;
  void search_layers(const System& system, int vertex, std::vector<NearTriangle>& found);
  void add_contact_point(const System& system, int vertex, double area, double side, FacedLayer& layer,
                         std::vector<ContactPoint>& points) const;
  bool search_due(const System& system);

  int body_;
  double stiffness_;
  std::vector<double> thickness_;
  std::array<std::vector<FacedLayer>, 2> layers_; ///< the layers that each vertex faces on its outer and its inner side
  std::vector<std::vector<int>> neighbours_;      ///< per vertex: itself and its neighbours along edges, ascending
  std::vector<std::vector<int>> adjacent_triangles_; ///< per triangle: the triangles that share a vertex with it
  std::unique_ptr<BroadPhase> boxes_;
  Vectors unit_normals_, last_positions_; ///< unit normals of all vertices; positions at the last search_due(), mm
  double travel_ = 0;                     ///< sum of the largest displacements since the last search, mm
};

} // namespace vci
