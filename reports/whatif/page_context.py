"""Rows of the page on a case's other plans, and on the inputs that its FFR depends on."""

from reports.whatif.tables import QUANTITY_LABELS, STATE_LABELS, read_intervals, read_ranking, records

QUANTITY_DIGITS = {"ffr": 3, "minimal_stent_area_mm2": 2}
VARIED_INPUTS = {"flow": "what the flow rests on", "deployment": "that and the deployment's inputs"}


def planner_context(folder):
    """{plans, plans_error, intervals, ffr_ranges, deployment_varied} of a case's folder, for the page's templates.

    plans: rows of ranking.csv. plans_error: error of their FFR, None if not known. intervals: rows of the sampled
    intervals before and after the planned PCI. ffr_ranges: {state: (lower, upper)}, the interval of FFR over the flow's
    inputs in each state. If deployment_varied is true, that of the planned PCI is over the deployment's inputs too.
    """
    plans = read_ranking(folder)
    varied = read_intervals(folder)
    found = [(source, row) for source, table in varied.items() for row in records(table) if row["lower"] is not None]
    rows = [
        {
            **row,
            "name": f"{QUANTITY_LABELS[row['quantity']]} {STATE_LABELS[row['state']]}",
            "digits": QUANTITY_DIGITS[row["quantity"]],
            "words": VARIED_INPUTS[source],
        }
        for source, row in found
        if row["state"] in STATE_LABELS
    ]
    return {
        "plans": plans,
        "plans_error": next((row["ffr_error"] for row in plans if row["ffr_error"] is not None), None),
        "intervals": rows,
        "ffr_ranges": {row["state"]: (row["lower"], row["upper"]) for _, row in found if row["quantity"] == "ffr"},
        "deployment_varied": "deployment" in varied,
    }
