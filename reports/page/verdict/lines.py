"""The lines of the verdict."""

from common.patient.states import TRUE_STATES
from reports.page.verdict.warnings import no_warning_text, warning_groups
from reports.page.verdict.words import count_patients, difference, errors_text, ffr_around, ffr_computed, join, mean_ffr
from reports.page.verdict.words import named_errors, plural, significant, tested_errors
from reports.study.agreement import paired_values
from reports.study.inclusion import INCLUDED, ffr_before, patient_groups
from reports.study.nearer import FARTHER, FEWEST_PATIENTS, NEARER

IN_TRUTH = {"reference": "in the finite-element reference", "post": "in the lumen after the real PCI"}
TRUTH = {"reference": "the reference", "post": "the lumen after the real PCI"}
AT_WIRE = {"pre_minus_measured": "before PCI", "vci_minus_measured": "after virtual PCI"}


def verdict(contexts, agreement, nearer, failed=()):
    """[{title, text, warnings}]: the lines of the verdict, without those that would say nothing.

    contexts: case_context of each case, at least one. agreement, nearer: rows of the tables of these names. failed:
    entries of failed.json. warnings: result of `warning_groups` in the line "Warnings", empty in all others.
    """
    documents = [context["metrics"] for context in contexts]
    group, found = numbers_group(documents, agreement)
    agreement, nearer = ([row for row in table if row["patients"] == group] for table in (agreement, nearer))
    warnings = warning_groups(contexts)
    lines = [
        ("Patients", patients_text(documents, failed, group), []),
        ("FFR past the lesion", ffr_text(found, agreement), []),
        ("VCI or radius correction", nearer_text(agreement, nearer), []),
        ("Warnings", "" if warnings else no_warning_text(), warnings),
        ("What this cannot tell", limits_text(documents), []),
    ]
    return [{"title": title, "text": text, "warnings": of_line} for title, text, of_line in lines if text or of_line]


def numbers_group(documents, agreement):
    """(name, documents) of the group of patients whose numbers the verdict gives: usually the included patients.

    It is the excluded ones if agreement.csv has rows for them but none for the included.
    """
    groups = patient_groups(documents)
    return next((one for one in groups if any(row["patients"] == one[0] for row in agreement)), groups[0])


def patients_text(documents, failed, group):
    """How many patients, of which kind, how many meet the criterion of inclusion, and how many have no result.

    group: name of the group of patients whose numbers the verdict gives.
    """
    count, synthetic = len(documents), sum(one["kind"] == "synthetic" for one in documents)
    kinds = {"synthetic": synthetic, "with a given lumen": count - synthetic}
    known = [f"{number if number < count else 'all'} {kind}" for kind, number in kinds.items() if number]
    ffr = [ffr_before(one) for one in documents]
    included, unknown = len(dict(patient_groups(documents)).get(INCLUDED, [])), ffr.count(None)
    text = [f"{count_patients(count)}, {join(known)}." if count > 1 else f"1 patient, {known[0].removeprefix('all ')}."]
    if count == 1:
        before = "not known" if unknown else f"{ffr[0]:.2f}"
        text.append(f"FFR before PCI is {before}; below 0.80 is the criterion of inclusion.")
    else:
        how_many = {0: "None has", count: "All have", 1: "1 has"}.get(included, f"{included} have")
        text.append(f"{how_many} FFR below 0.80 before PCI, the criterion of inclusion.")
        text += [f"It is not known in {unknown}."] if unknown else []
    if included != count and count > 1:
        text.append(f"The numbers are of {f'these {included}' if group == INCLUDED else 'those not included'}.")
    lost = len({one["case"] for one in failed} - {one["case"] for one in documents})
    if lost:
        text.append(f"{lost} more case{plural(lost)} failed and {'has' if lost == 1 else 'have'} no result.")
    return " ".join(text)


def ffr_text(documents, agreement):
    """Sentences on FFR before PCI, after virtual PCI and in the known lumen after PCI, then on FFR against a wire.

    documents, agreement: metrics documents and rows of agreement.csv of one group of patients.
    """
    text, rows = [], {row["comparison"]: row for row in agreement if row["quantity"] == "ffr"}
    for truth in (truth for truth in TRUE_STATES if f"vci_minus_{truth}" in rows):
        row, cases = rows[f"vci_minus_{truth}"], paired_values(documents, "ffr", "vci", truth)[0]
        before = mean_ffr([one for one in documents if one["case"] in cases], "pre")
        predicted, known = (ffr_around(row[f"mean_{one}"], row[f"sd_{one}"]) for one in "ab")
        some = f" ({row['n']} of {len(documents)} patients)" if row["n"] < len(documents) else ""
        text.append(f"{before} before PCI, {predicted} after virtual PCI (VCI), {known} {IN_TRUTH[truth]}{some}.")
        text.append(f"VCI minus {TRUTH[truth]}: {difference(row)}; {flow_error([row])}.")
    if not text:
        predicted = [one for one in documents if ffr_computed(one, "vci") is not None]
        if not predicted:
            return "No FFR was computed after PCI."
        text.append(f"{mean_ffr(predicted, 'pre')} before PCI, {mean_ffr(predicted, 'vci')} after virtual PCI (VCI).")
        text += [] if "vci_minus_measured" in rows else ["No FFR after PCI is known to compare with."]
    for row in (rows[comparison] for comparison in AT_WIRE if comparison in rows):
        moment = AT_WIRE[row["comparison"]]
        text.append(f"Computed minus measured by pressure wire {moment}: {difference(row)} (n = {row['n']}).")
    return " ".join(text)


def nearer_text(agreement, nearer):
    """Sentences: which prediction is nearer to each lumen after PCI, in which quantity, and whether a test decides."""
    text = []
    for truth in TRUE_STATES:
        rows = {row["quantity"]: row for row in nearer if row["truth"] == truth}
        if rows:
            text.append(f"Mean errors against {TRUTH[truth]}, VCI's first.")
        if "ffr" in rows:
            names = [f"{state}_minus_{truth}" for state in ("vci", "rc")]
            compared = [row for row in agreement if row["quantity"] == "ffr" and row["comparison"] in names]
            text.append(ffr_nearer_text(rows.pop("ffr"), compared))
        text += geometry_nearer_text(list(rows.values()))
    return " ".join(text)


def ffr_nearer_text(row, compared):
    """A sentence on whether FFR decides between VCI and radius correction.

    It decides only if the test does, and if the mean errors differ by more than the flow's own estimated error.
    row: FFR's row of nearer.csv. compared: FFR's rows of agreement.csv for both methods.
    """
    estimate = largest_error(compared)
    if estimate is None:
        why = flow_error(compared)
    elif abs(row["error_vci"] - row["error_rc"]) <= estimate:
        why = f"{flow_error(compared)}, no less than their difference"
    elif row["vci_is"] in (NEARER, FARTHER):
        who = "VCI" if row["vci_is"] == NEARER else "Radius correction"
        return f"{who} is nearer in FFR ({tested_errors(row)}); {flow_error(compared)}."
    else:
        why = f"{too_few(row)} for a test" if row["p"] is None else f"p = {significant(row['p'])}"
    return f"FFR does not decide ({errors_text(row)}): {why}."


def geometry_nearer_text(rows):
    """Sentences on the areas and the curvature. rows: rows of nearer.csv for one lumen after PCI."""
    tested, few = ([row for row in rows if (row["p"] is None) == untested] for untested in (False, True))
    lists = {
        "VCI is nearer in": [row for row in tested if row["vci_is"] == NEARER],
        "Radius correction is nearer in": [row for row in tested if row["vci_is"] == FARTHER],
        "No difference is shown in": [row for row in tested if row["vci_is"] not in (NEARER, FARTHER)],
    }
    text = [f"{words} {join([named_errors(row) for row in found])}." for words, found in lists.items() if found]
    if few:
        smaller = {
            "VCI's error is smaller in": [row for row in few if row["error_vci"] < row["error_rc"]],
            "radius correction's error is smaller in": [row for row in few if row["error_vci"] > row["error_rc"]],
        }
        known = [f"{words} {join([named_errors(row) for row in found])}" for words, found in smaller.items() if found]
        text.append("; ".join([f"{too_few(few[0])} for a test, which needs {FEWEST_PATIENTS}", *known]) + ".")
    return text


def limits_text(documents):
    """What the study's comparisons cannot show."""
    reference, real = (sum(truth in one["states"] for one in documents) for truth in TRUE_STATES)
    wires = [(one.get("measured") or {}).get("ffr_post") is not None for one in documents]
    known = [wire or bool(set(TRUE_STATES) & set(one["states"])) for wire, one in zip(wires, documents)]
    if not any(known):
        return "Nothing is known after PCI, so the prediction is untested."
    text = []
    if reference:
        text.append("The reference shares lumen, plan and flow solver with the prediction: their errors do not show.")
    if real:
        text.append("Errors against a lumen after real PCI hold those of both images.")
    if not (real or any(wires)):
        text.append("Nothing was compared with images or pressures of patients after PCI.")
    if not all(known):
        untested = known.count(False)
        text.append(f"In {count_patients(untested)} nothing is known after PCI: there the prediction is untested.")
    return " ".join(text)


def largest_error(rows):
    """The largest estimated error of FFR in rows of agreement.csv; None if one is not known."""
    estimates = [row["largest_estimate"] for row in rows]
    return None if None in estimates else max(estimates)


def flow_error(rows):
    """The flow's estimated error in words, from rows of agreement.csv."""
    largest = largest_error(rows)
    return "the flow's own error is " + ("not known" if largest is None else f"up to {significant(largest)}")


def too_few(row):
    """Words that say: the patients of this row of nearer.csv are too few. Ties do not count."""
    decided = row["n"] - row["ties"]
    words = count_patients(decided) + (" without a tie" if row["ties"] else "")
    return f"{words} {'is' if decided == 1 else 'are'} too few"
