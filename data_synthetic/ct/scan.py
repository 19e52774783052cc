"""Makes the CT volume of a lumen surface, and the JSON file (sidecar) that describes it."""

import hashlib
import pathlib

import numpy as np

from common import vtp
from common.documents import config
from common import volume as image
from common.errors import InputError
from common.files import write_json

from ..scene import load as load_scene
from . import phantom, struts, vessel

SCHEMA = "vci-ct-1"


def run(lumen_path, out, settings_path=None, struts_path=None, scene_path=None, centreline_path=None):
    """Writes `out`/ct.nii.gz and `out`/ct.json for the lumen at lumen_path; returns the latter's content.

    Stents are given in one of two ways, or there are none. struts_path: a file of lines, whose thickness is in the
    settings; scene_path is then not used. scene_path: a scene whose stents, with their own thickness, are laid on this
    lumen along its centreline. Raises InputError.
    """
    settings = config.load_section(settings_path, "ct")["phantom"]
    poly = vtp.read_triangles(lumen_path, "run the anatomy step first")
    scanned = vessel.from_surface(poly, lumen_path)
    metal, source = None, "none"
    if struts_path:
        centres, lengths = struts.read_struts(struts_path)
        metal, source = (centres, lengths * settings["strut_thickness_mm"] ** 2), "lines of a file"
    elif scene_path:
        if not centreline_path:
            raise InputError("stents need the lumen's centreline", "--centreline", "missing", "give centreline.vtp")
        scene = load_scene(scene_path)
        lines = vtp.read_named_lines(centreline_path, "the anatomy's centreline.vtp")
        metal = struts.struts_of_scene(scene, poly, lines, scene_path)
        source = "rings laid on the wall" if metal else "none"
    volume = phantom.add_noise(phantom.render(scanned, settings, metal), settings)
    document = sidecar(volume, settings, pathlib.Path(lumen_path), source)
    text = f"CT angiogram, synthetic; PSF {settings['psf_fwhm_mm']} mm, noise {settings['noise_hu']} HU"
    image.write(volume, pathlib.Path(out) / "ct.nii.gz", text)
    write_json(pathlib.Path(out) / "ct.json", document)
    return document


def sidecar(volume, settings, lumen_path, strut_source):
    """The content of ct.json: scanner, tissue and noise of a volume, and the lumen and struts that it was made from.

    Its effective_fwhm_mm is the width of the point spread together with the blur by the voxel's own size.
    """
    voxel = np.array(settings["voxel_mm"])
    sigma = settings["psf_fwhm_mm"] * image.SIGMA_PER_FWHM
    total = np.sqrt(sigma**2 + voxel**2 / 12) / image.SIGMA_PER_FWHM
    return {
        "schema": SCHEMA,
        "modality": "CT",
        "units": "HU",
        "source": {"lumen": lumen_path.name, "sha256": hashlib.sha256(lumen_path.read_bytes()).hexdigest()},
        "shape": [int(n) for n in volume.values.shape],
        "origin_mm": volume.origin_mm.tolist(),
        "spacing_mm": volume.spacing_mm.tolist(),
        "effective_fwhm_mm": total.round(4).tolist(),
        "noise": "white" if settings["noise_correlation_mm"] == 0 else "correlated (Gaussian kernel)",
        "clipped_hu": [image.LOWEST_HU, image.HIGHEST_HU],
        "struts": strut_source,
        "settings": settings,
    }
