"""A wall that is not as bright as the edges assume: the error that is stated is the one that is made."""

import ct_vessels
import numpy as np
import pytest

from anatomy.ct import segment


@pytest.mark.parametrize("blood, wall", [(400.0, 50.0), (260.0, 50.0), (400.0, 110.0), (260.0, 110.0), (400.0, -80.0)])
def test_the_stated_error_is_that_of_the_radius(blood, wall):
    image = ct_vessels.image(blood=blood, wall=wall)
    found = segment.segment(image, ct_vessels.ends(), ct_vessels.settings())
    said = [w for w in found["warnings"] if w["code"] == "wall_brightness"]
    tube = found["tubes"][0]
    off = float(np.mean(tube.radius(tube.s_mm))) - ct_vessels.RADIUS_MM
    if wall == 50.0:
        assert not said and abs(off) < 0.03
        return
    stated = float(said[0]["message"].split("by about ")[1].split(" mm")[0])
    assert stated == pytest.approx(abs(off), rel=0.4) and ("too large" in said[0]["message"]) == (off > 0)
    assert said[0]["value"] == pytest.approx(wall, abs=20)
