"""All figures of one case."""

from reports.figures.curves import area_figure, curvature_figure, pullback_figure
from reports.figures.lumen import lumen_figure
from reports.figures.stations import stations_figure
from reports.inputs.reading import read_json


def case_figures(files, folder):
    """Writes <case>_{lumen,pullback,stations,area,curvature}.{svg,png} into `folder`; needs the case's metrics.json."""
    metrics = read_json(files.metrics, "reports metrics")
    lumen_figure(files, metrics, folder)
    pullback_figure(files, metrics, folder)
    stations_figure(files, metrics, folder)
    area_figure(metrics, folder)
    curvature_figure(metrics, folder)
