"""Warnings about a pull-back that can be read, but probably has other units, another direction, mixed phases or damage.

Each warning compares the pull-back with usual coronary arteries and catheters. None changes the result.
"""

import numpy as np

from . import rings

WIDENING_RATIO = (
    1.1  # a warning is given if the distal third's diameter is more than this many times the proximal third's
)
HEALTHY_PERCENTILE = 90  # percentile of a third's diameters that stands for it, so that a lesion in it does not count
# Range of usual median diameters. Mean radii of coronary arteries, even of ectatic ones, are 0.6 to 3 mm.
WIDEST_USUAL_MM, NARROWEST_USUAL_MM = 6.0, 1.2
# Systole and diastole are mixed if areas alternate: by turns they are larger and smaller than the mean of their two
# neighbours. The limits are the share of frames that alternate, the median difference from this mean in per cent, and
# the number of frames. In outlines of one phase three of four frames alternate too. Systole differs from diastole by
# 8 % and more.
ALTERNATING_SHARE, PHASES_PERCENT, PHASES_FRAMES = 0.9, 5.0, 8
SHORTEST_DIAMETERS = 2.0  # least usual length of a pull-back, in median diameters: it covers at least a lesion
# A warning is given if two frames less than NEIGHBOUR_MM apart differ in area by more than a factor SUDDEN_RATIO. It
# names MOST_NAMED places. In four real pull-backs with frames less than 1 mm apart the largest factors are 1.97 and
# 1.62.
NEIGHBOUR_MM, SUDDEN_RATIO, MOST_NAMED = 1.0, 2.0, 3
# Largest usual ratio of an outline's longest step to its third longest step. Drawn and real outlines have 1.3 at most.
OPEN_STEP_RATIO = 3.0
COUNTED_FRAMES = (
    8  # least number of frames for _frame_numbers_as_z: in fewer frames z may be whole millimetres by chance
)


def find_warnings(pull):
    """The warnings [str] on a Pullback's width, length, units of z, direction, phases and single frames."""
    areas = np.array([rings.area_mm2(frame.lumen) for frame in pull.frames])
    sentences = [
        *_width(areas),
        *_length(pull, areas),
        *_frame_numbers_as_z(pull),
        *_widening(pull, areas),
        *_mixed_phases(areas),
    ]
    return [*sentences, *_sudden_changes(pull, areas), *_open_outlines(pull)]


def _width(areas):
    usual = 2 * np.sqrt(np.median(areas) / np.pi)
    if not NARROWEST_USUAL_MM <= usual <= WIDEST_USUAL_MM:
        yield (
            f"the lumen is {usual:.2f} mm wide (median), coronary arteries {NARROWEST_USUAL_MM:g} to"
            f" {WIDEST_USUAL_MM:g} mm: check units, or the size of a pixel"
        )


def _length(pull, areas):
    length, usual = np.ptp(pull.z_mm), 2 * np.sqrt(np.median(areas) / np.pi)
    if length < SHORTEST_DIAMETERS * usual:
        yield (
            f"the pull-back is {length:.2f} mm long, its lumen {usual:.2f} mm wide (median): are z, x and y in the same"
            " unit?"
        )


def _frame_numbers_as_z(pull):
    """Warns if the column z seems to hold frame numbers instead of millimetres.

    Either z equals the frame's number. Or z is whole and the frame's number is not, so the columns may be exchanged.
    """
    if len(pull.frames) < COUNTED_FRAMES or not all(isinstance(frame.name, (int, float)) for frame in pull.frames):
        return
    names, z = np.array([frame.name for frame in pull.frames], float), pull.sign * pull.z_mm
    length = f"over {np.ptp(z):g} mm. If z counts frames, multiply it by their distance"
    if np.abs(z - names).max() < 1e-6:
        yield f"z is the frame's number in all {len(z)} frames, {length}"
    elif np.abs(z - np.round(z)).max() < 1e-6 < np.abs(names - np.round(names)).max():
        yield (
            "z is a whole number in all frames and the frame is not: are the two columns exchanged? z reaches"
            f" {length}"
        )


def _widening(pull, areas):
    third = np.ptp(pull.z_mm) / 3
    thirds = pull.z_mm <= pull.z_mm[0] + third, pull.z_mm >= pull.z_mm[-1] - third
    distal, proximal = (np.percentile(np.sqrt(areas[end]), HEALTHY_PERCENTILE) for end in thirds)
    if distal > WIDENING_RATIO * proximal:
        yield (
            f"the distal third is {distal / proximal:.2f} times as wide as the proximal one: does z rise from the"
            " distal end? Otherwise set z_from: proximal (--z-from). A narrowed or anomalous first part looks the same"
        )


def _mixed_phases(areas):
    if len(areas) < PHASES_FRAMES:
        return
    off = areas[1:-1] / (0.5 * (areas[:-2] + areas[2:])) - 1
    alternating = np.mean(np.sign(off[1:]) != np.sign(off[:-1]))
    percent = 100 * np.median(np.abs(off))
    if alternating >= ALTERNATING_SHARE and percent >= PHASES_PERCENT:
        yield (
            f"areas rise and fall by turns, by {percent:.0f} % from frame to frame (median): are systole and diastole"
            " mixed? Use the frames of one phase, best diastole (drop_frames)"
        )


def _sudden_changes(pull, areas):
    """Warns of neighbouring frames of which one is much wider: a wrong outline, or the guide catheter's lumen."""
    ratio = np.exp(np.abs(np.diff(np.log(areas))))
    pairs = np.flatnonzero((ratio > SUDDEN_RATIO) & (np.diff(pull.z_mm) < NEIGHBOUR_MM))
    places = [
        f"{one.name} to {other.name} (z {pull.sign * one.z_mm:.2f} to {pull.sign * other.z_mm:.2f} mm,"
        f" {areas[k]:.2f} to {areas[k + 1]:.2f} mm2)"
        for k in pairs
        for one, other in [pull.frames[k : k + 2]]
    ]
    if places:
        yield (
            f"the lumen's area changes by more than a factor of {SUDDEN_RATIO:g} within {NEIGHBOUR_MM:g} mm, in frames"
            f" {_list_first(places)}: a wrong outline? Leave such a frame out (drop_frames). Frames in the"
            " guide catheter? Leave them out by z_range_mm. A short lesion or a large branch's mouth looks the same"
        )


def _open_outlines(pull):
    """Warns of outlines with a gap or a spike.

    A gap is a single long step; a spike is two long steps, to a point and back. A step is long if it exceeds three
    times the third longest step and the outline's own radius. A chord as long as the radius cuts 3 % off a circle's
    area.
    """
    places = []
    for frame in pull.frames:
        for name, outline in (("lumen", frame.lumen), ("outer wall", frame.outer_wall)):
            if outline is None:
                continue
            third, _, longest = np.sort(np.linalg.norm(outline - np.roll(outline, 1, axis=0), axis=1))[-3:]
            if longest > max(OPEN_STEP_RATIO * third, np.sqrt(rings.area_mm2(outline) / np.pi)):
                places.append(f"{frame.name} (z {pull.sign * frame.z_mm:.2f} mm, {name}, {longest:.2f} mm)")
    if places:
        yield (
            f"a step of an outline is longer than the lumen's or wall's own radius and {OPEN_STEP_RATIO:g} times the"
            f" others, in frame {_list_first(places)}: is a part missing, or a point far off? Trace it again, or leave"
            " the frame out (drop_frames)"
        )


def _list_first(places):
    """The first MOST_NAMED of several places in words, and how many more there are."""
    return ", ".join(places[:MOST_NAMED]) + f" and {len(places) - MOST_NAMED} more" * (len(places) > MOST_NAMED)
