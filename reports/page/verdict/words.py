"""Numbers and names in words, for the sentences of the verdict."""

from reports.page.agreement import QUANTITY_NAMES, row_digits, unit_name
from reports.page.digits import decimals
from reports.study.bland_altman import sample_sd


def ffr_computed(document, state):
    """FFR past the lesion of a state of a metrics document; None without the state or without a flow."""
    entry = document["states"].get(state)
    return entry["ffr"]["distal"] if entry and entry["ffr"] else None


def mean_ffr(documents, state):
    """Mean and standard deviation of FFR in a state over the documents that have it, as text; a dash if none has."""
    values = [ffr for ffr in (ffr_computed(one, state) for one in documents) if ffr is not None]
    return ffr_around(sum(values) / len(values), sample_sd(values)) if values else "–"


def ffr_around(mean, sd):
    """A mean FFR with its standard deviation (None for one patient), with 2 decimals, or 3 for a small deviation."""
    digits = 2 if not sd else min(3, max(2, decimals(sd, 1)))
    return f"{mean:.{digits}f}" + ("" if sd is None else f" ± {sd:.{digits}f}")


def difference(row):
    """Bias and standard deviation of a row of agreement.csv, with as many decimals as in the page's table."""
    digits = row_digits(row)
    bias = f"{row['bias']:+.{digits}f}".replace("-", "−")
    return bias + ("" if row["sd"] is None else f" ± {row['sd']:.{digits}f}")


def significant(value):
    """A positive number with two significant digits."""
    return f"{value:.{decimals(value, 2)}f}"


def errors_text(row):
    """Both mean errors of a row of nearer.csv with their unit: "0.13 and 0.47 mm²"."""
    return f"{significant(row['error_vci'])} and {significant(row['error_rc'])} {unit_name(row)}".strip()


def tested_errors(row):
    """Both mean errors of a row of nearer.csv, and p of its test: "0.13 and 0.47 mm², p = 0.0039"."""
    return errors_text(row) + ("" if row["p"] is None else f", p = {significant(row['p'])}")


def named_errors(row):
    """A quantity with its mean errors and p: "mean CSA (0.13 and 0.47 mm², p = 0.0039)"."""
    name = QUANTITY_NAMES[row["quantity"]]
    return f"{name[0].lower()}{name[1:]} ({tested_errors(row)})"


def count_patients(count):
    """A number of patients in words."""
    return f"{count} patient{plural(count)}"


def plural(count):
    """The ending of a noun after this number: nothing after 1, else "s"."""
    return "" if count == 1 else "s"


def join(texts):
    """A list as text: "a, b and c"."""
    return " and ".join(filter(None, [", ".join(texts[:-1]), texts[-1]]))
