"""The plans whose flow `make best-plans` solves in three dimensions."""

import pytest

from common.errors import InputError
from whatif.best_plans import flows_of_best_plans


def write_ranking(results, case, rows):
    folder = results / "cases" / case / "plans"
    folder.mkdir(parents=True)
    lines = ["rank,plan,status", *(f"{rank},{plan},deployed" for rank, plan in rows)]
    (folder / "ranking.csv").write_text("\n".join(lines) + "\n")
    return folder


def test_the_best_plans_of_each_case_without_its_own_plan(tmp_path):
    first = write_ranking(tmp_path, "a", [(2, "planned"), (1, "larger"), (3, "longer"), ("", "shorter")])
    second = write_ranking(tmp_path, "b", [(1, "longer"), (2, "pressure"), (10, "larger"), (3, "planned")])
    found = flows_of_best_plans(["a", "b"], tmp_path)
    plans = [first / "larger", second / "longer", second / "pressure"]
    assert found == [str(plan / "flow" / "ffr.json") for plan in plans]
    assert len(flows_of_best_plans(["a", "b"], tmp_path, 10)) == 5, "a refused plan has no rank, and no flow"
    assert len(flows_of_best_plans(["b"], tmp_path)) == 2, "a case of another study stays as it is"


def test_a_case_without_a_ranking_is_refused(tmp_path):
    write_ranking(tmp_path, "a", [(1, "larger")])
    with pytest.raises(InputError, match="a case has no ranking of plans"):
        flows_of_best_plans(["a", "b"], tmp_path)
