"""Figures of the deployment's benchmarks: errors against CPU seconds with their Pareto fronts."""

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402


def pareto(points):
    """The Pareto front of (cost, error) pairs, sorted by cost: each has a smaller error than all cheaper pairs."""
    front = []
    for cost, error in sorted(points):
        if not front or error < front[-1][1]:
            front.append((cost, error))
    return front


def draw_speed(rows, median_rows, errors, path):
    """Draws errors of the mean and the minimal area against CPU seconds, and the cost of a step per wall vertex.

    rows, median_rows: rows of benchmark.csv and of medians.csv; the Pareto front is that of the medians. errors:
    columns of both errors. path: file of the picture.
    """
    figure, (*error_axes, cost) = pyplot.subplots(1, 3, figsize=(16, 4))
    for axes, key, area_name in zip(error_axes, errors, ("mean", "minimal")):
        for case in dict.fromkeys(r["case"] for r in rows):
            points = [r for r in rows if r["case"] == case and r.get(key)]
            axes.loglog([r["cpu_seconds"] for r in points], [abs(r[key]) for r in points], "o", label=case)
        front = pareto([(r["cpu_seconds"], r[key]) for r in median_rows if r[key]])
        if front:
            axes.loglog(*zip(*front), "k-", label="front of the medians")
        axes.set(xlabel="CPU seconds, one core", ylabel=f"error of the {area_name} area in the stent, %")
    error_axes[1].legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.15), ncol=3, fontsize=8
    )  # below the axes, where it hides no points
    key = "microseconds_per_vertex_step"
    timed_rows = [r for r in rows if key in r]
    cost.semilogx([r["wall_vertices"] for r in timed_rows], [r[key] for r in timed_rows], "o")
    cost.set(xlabel="vertices of the wall", ylabel="microseconds per vertex and step", ylim=(0, None))
    figure.savefig(path, dpi=150, bbox_inches="tight")


def draw_fronts(rows, schemes, key, path):
    """Draws errors of the mean area against CPU seconds, in a plot for each scene, with a Pareto front for each scheme.

    rows: rows of baseline.csv. key: column of the error. path: file of the picture.
    """
    cases = list(dict.fromkeys(r["case"] for r in rows))
    figure, axes_grid = pyplot.subplots(1, len(cases), figsize=(5 * len(cases), 4), sharey=True, squeeze=False)
    legend_lines = {}
    for axes, case in zip(axes_grid[0], cases):
        for k, scheme in enumerate(schemes):
            points = [
                (r["cpu_seconds"], abs(r[key])) for r in rows if (r["case"], r["scheme"]) == (case, scheme) and key in r
            ]
            if points:
                (legend_lines[scheme],) = axes.loglog(*zip(*points), "o", color=f"C{k}")
                axes.loglog(*zip(*pareto(points)), "-", color=f"C{k}")
        axes.set(title=case, xlabel="CPU seconds, one core")
    axes_grid[0][0].set_ylabel("error of the mean area in the stent, %")
    figure.legend(legend_lines.values(), legend_lines, loc="upper center", bbox_to_anchor=(0.5, 0), ncol=len(schemes))
    figure.savefig(path, dpi=150, bbox_inches="tight")
