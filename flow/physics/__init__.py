"""Physics: viscosity, outlets, what is read of a flow (FFR, wall shear stress, energy)."""
