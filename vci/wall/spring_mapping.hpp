// The mapping from a triangle's stiffness to the stiffnesses of springs along its edges.
#pragma once

namespace vci {

/// The stiffness of the spring that a triangle gives to one of its edges:
///   lame        L^2 (2 cot^2(alpha) (lambda + mu) + mu) / (8 A)
///   van_gelder  E t A / L^2
/// E t is the triangle's modulus times its thickness. A is its area, L the edge's length, alpha the angle opposite the
/// edge. The Lame constants are those of plane stress, times the thickness:
///   lambda = E t nu / (1 - nu^2),  mu = E t / (2 (1 + nu))
///
/// `lame` has the tensile springs of Delingette (Triangular springs for modeling nonlinear membranes, IEEE TVCG 14(2),
/// 2008). They are made linear in the length, and his angular springs are left out.
/// `van_gelder`: Approximate simulation of elastic membranes by triangulated spring meshes, J. Graphics Tools 3(2),
/// 1998.
/// With either, the surface's stiffness depends on the mesh and on Poisson's ratio.
enum class SpringMapping { lame, van_gelder };

} // namespace vci
