"""Linear answers of a solved flow: how it changes with loads on its equations, and which loads change a goal."""

import numpy as np
from petsc4py import PETSc


class Sensitivity:
    """K is Newton's tangent at the solved flow; what a subclass sets: solvers.nonlinear.FlowProblem."""

    def dual(self, goal):
        """Values (n,) over W of z with K^T z = goal; goal: vector over W."""
        return self._with_inlet(*self.answers(goal.array_r[:, None], [0.0], True))[:, 0]

    def responses(self, loads):
        """Values (n, k) over W of w with K w = load for each of loads (n, k); z of a goal times a load is the goal
        times its w."""
        given = self.boundaries.inflow is not None
        profile = self.boundaries.profile.x.array
        on_inflow = np.zeros(loads.shape[1]) if given else profile @ loads
        return self._with_inlet(*self.answers(loads, on_inflow, False))

    def _with_inlet(self, values, inflows):
        """values (n, k) with the inlet's dofs; where the inflow is given they do not change, and test nothing."""
        if self.boundaries.inflow is None:
            inlet = self.space.inlet
            values[inlet] = np.outer(self.boundaries.profile.x.array[inlet], inflows)
        return values

    def answers(self, loads, on_inflow, transposed):
        """(values (n, k) over W, 0 in fixed dofs; inflows (k,)) that solve with K, or K^T, for loads (n, k) over W and
        (k,) on the inflow's equation. The last factorization serves, which is of a state near by (solvers.newton)."""
        if self.bordered is None or self.linearised_as != (True, self.artificial):
            self.linearise(self.forms.tangent)
        bordered = self.bordered.transpose() if transposed else self.bordered
        rights = [PETSc.Vec().createWithArray(load[self.space.free], comm=PETSc.COMM_SELF) for load in loads.T]
        given = np.zeros((len(rights), len(bordered.rows)))
        given[:, 0] = on_inflow
        values, inflows = np.zeros(loads.shape), np.zeros(len(rights))
        for k, (x, y) in enumerate(bordered.solve_all(rights, given)):
            values[self.space.free, k], inflows[k] = x.array_r, y[0]
            x.destroy()
        for right in rights:
            right.destroy()
        if transposed:
            bordered.destroy()
        return values, inflows
