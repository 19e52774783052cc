"""The patients that enter the statistics: as in Lyu et al. 2025, those with FFR below 0.80 before PCI.

No row mixes them with the other patients, who have rows of their own, under the name "excluded".
"""

from reports.inputs.reading import number
from reports.measuring.pressure_wire import FFR_THRESHOLD

INCLUDED, EXCLUDED = "included", "excluded"
GROUPS = (INCLUDED, EXCLUDED)


def ffr_before(document):
    """FFR before PCI of a metrics document: the pressure wire's, else the one computed past the lesion.

    None if there is neither.
    """
    measured = document.get("measured")
    if measured and measured["ffr_pre"] is not None:
        return measured["ffr_pre"]
    entry = document["states"].get("pre")
    return number(entry, "ffr.distal", f"metrics of {document['case']}, pre") if entry and entry["ffr"] else None


def meets_criterion(ffr):
    """Whether a patient with this FFR before PCI is included; None if FFR is not known."""
    return None if ffr is None else ffr < FFR_THRESHOLD


def patient_groups(documents):
    """[(name of GROUPS, metrics documents)], without a group that has no patient."""
    split = {name: [] for name in GROUPS}
    for document in documents:
        split[INCLUDED if meets_criterion(ffr_before(document)) else EXCLUDED].append(document)
    return [(name, found) for name, found in split.items() if found]


def analysed_documents(documents):
    """The documents that a figure shows: those of the included patients, or of the others if none is included."""
    return patient_groups(documents)[0][1] if documents else []
