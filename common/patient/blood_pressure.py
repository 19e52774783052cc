"""Mean arterial pressure from a patient's cuff pressures."""

from common.errors import InputError


def mean_arterial_pressure_mmhg(sbp_mmhg, dbp_mmhg):
    """MAP in mmHg: the diastolic pressure plus 0.4 of the pulse pressure (Bos et al., J Hypertens 25 (2007) 751).

    sbp_mmhg, dbp_mmhg: systolic and diastolic pressure in mmHg. Raises InputError if they are out of order.
    """
    if not 0 < dbp_mmhg < sbp_mmhg:
        raise InputError(
            "blood pressures out of order",
            "patient sbp_mmhg, dbp_mmhg",
            f"{sbp_mmhg}, {dbp_mmhg}",
            "give 0 < diastolic < systolic in mmHg",
        )
    return dbp_mmhg + 0.4 * (sbp_mmhg - dbp_mmhg)
