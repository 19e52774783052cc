// How a triangle's stiffness becomes that of springs along its edges.
#pragma once

namespace vci {

/// With E t a triangle's modulus times thickness, A its area, L an edge, alpha the angle opposite to it, and the Lame
/// constants of plane stress times thickness, lambda = E t nu / (1 - nu^2), mu = E t / (2 (1 + nu)):
///   lame        L^2 (2 cot^2(alpha) (lambda + mu) + mu) / (8 A): the tensile springs of Delingette (Triangular springs
///               for modeling nonlinear membranes, IEEE TVCG 14(2), 2008), linear in the length, without his angular
///               ones
///   van_gelder  E t A / L^2 (Approximate simulation of elastic membranes by triangulated spring meshes, J. Graphics
///               Tools 3(2), 1998)
/// No choice makes springs independent of mesh and Poisson's ratio.
enum class SpringMapping { lame, van_gelder };

} // namespace vci
