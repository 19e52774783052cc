"""The published numbers: each says where it was read, keeps its digits, and is shown with both."""

import matplotlib.pyplot as plt
import pandas as pd
import pytest

from reports.figures import seconds
from reports.page.build import environment
from reports.study.agreement import published_provenance, published_results

TIMINGS = pd.DataFrame(
    [
        {"case": case, "step": f"vci/{step}/{stage}", "source": "program", "seconds": 4.0}
        for case in ("one", "two")
        for step in ("stent", "proximal_optimisation")
        for stage in ("deployment-to-contact", "balloon-extraction")
    ]
)


def numbers(value, path=""):
    """Paths of all numbers within a document, keys joined by points."""
    if isinstance(value, dict):
        return [found for key, inner in value.items() for found in numbers(inner, f"{path}.{key}".lstrip("."))]
    return [path] if isinstance(value, (int, float)) else []


@pytest.fixture
def figure(monkeypatch):
    """The figure of the seconds of two cases."""
    drawn = []
    monkeypatch.setattr(seconds, "save_figure", lambda figure, folder, name: drawn.append(figure))
    seconds.seconds_figure(TIMINGS, None)
    yield drawn[0]
    plt.close(drawn[0])


def bars(axes):
    """[(x, low, high)] of the bars on the published values of a panel."""
    lines = [container.lines[2][0] for container in axes.containers]
    return [(line[0, 0], *line[:, 1]) for of_one in lines for line in of_one.get_segments()]


def means(axes):
    """[[x, mean]] of the published values of a panel."""
    (marks,) = (line for line in axes.lines if line.get_label() == "published mean")
    return marks.get_xydata().tolist()


def test_each_number_was_read_in_one_place():
    published = published_results()
    values = [name for source in published["provenance"].values() for name in source["values"]]
    for path in numbers(published):
        named = [name for name in values if f"{path}.".startswith(f"{name}.")]
        assert len(named) == 1 or path == "decimals", path
    paths = numbers(published) + ["machine"]
    assert not [name for name in values if not any(f"{path}.".startswith(f"{name}.") for path in paths)]


@pytest.mark.parametrize(
    "name, words",
    [
        ("quantities.ffr.bias", "the abstract of the article, which was read"),
        ("seconds.all", "the abstract of the article, which was read"),
        ("seconds.stage", "the full text of the article, as noted when the project was set up; not read again since"),
        ("seconds.step.stent", "the full text of the article, as noted"),
        ("example", "the full text of the article, as noted"),
    ],
)
def test_where_a_number_was_read(name, words):
    assert words in published_provenance(name)


def test_a_value_of_no_known_place_is_refused():
    with pytest.raises(KeyError):
        published_provenance("seconds")  # partly from the abstract, partly from the full text


def test_the_figures_of_the_example_say_where_they_were_read():
    contrast = [{"name": "a", "description": "", "rows": []}]
    page = environment().get_template("contrast.html.j2")
    text = page.render(contrast=contrast, published=published_results(), excluded_patients=())
    assert "has FFR 0.86 by radius" in text and f"The three figures are {published_provenance('example')}." in text


def test_the_published_deviation_is_drawn_where_there_is_one(figure):
    by_stage, by_step, in_all = figure.axes
    assert bars(in_all) == [(1.0, 23.92, 25.92)] and in_all.get_xlabel() == "published:\n24.92 ± 1.00 s"
    assert in_all.get_ylim()[1] > 25.92
    assert bars(by_stage) == bars(by_step) == []
    assert means(by_stage) == [[1.0, 8.79], [2.0, 9.17]] and means(in_all) == [[1.0, 24.92]]
    assert means(by_step) == [[1.0, 8.5]], "the source has no second step of this name"


def test_a_panel_without_any_published_value_is_drawn():
    _, axes = plt.subplots()
    seconds.draw_published(axes, [None])
    assert bars(axes) == means(axes) == []
    plt.close()
