"""Small systems of equations that take the place of a flow in tests of the solvers."""

import types

import numpy as np

from flow.solvers import anderson


class Equations:
    """F(x) = 0 with the methods of solvers.nonlinear.FlowProblem that Newton's method uses."""

    def __init__(self, function, jacobian, start):
        self.function, self.jacobian, self.norms = function, jacobian, []
        self.state = types.SimpleNamespace(x=types.SimpleNamespace(array=np.array(start, float)))
        self.inflow, self.pressure_load = 0.0, 1.0
        self.solver = types.SimpleNamespace(factorizations=0)
        self.forms = types.SimpleNamespace(tangent=None)
        self.space = types.SimpleNamespace(free_dofs=slice(None))
        self.allowed_factorizations, self.said = 100, []

    def acceleration(self):
        return anderson.AndersonAcceleration(np.append(np.ones(len(self.state.x.array)), 0.0))

    def mark_outdated(self):
        self.said.append("outdated")

    @property
    def factorizations_left(self):
        return self.allowed_factorizations - self.solver.factorizations

    def residual(self):
        values = np.array(self.function(self.state.x.array), float)
        return values, 0.0, float(np.linalg.norm(values))

    def linearise(self, form):
        self.solver.factorizations += 1
        self.matrix = np.array(self.jacobian(self.state.x.array), float)

    def correction(self, residual, inlet):
        return -np.linalg.solve(self.matrix, residual), 0.0

    def move(self, base, base_inflow, update, inflow_update, factor):
        self.state.x.array = base + factor * update

    def velocity_norm(self, update):
        return float(np.linalg.norm(update))

    def report(self, norm, kind):
        self.norms.append(norm)
        self.said.append(kind)
