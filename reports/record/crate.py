"""ro-crate-metadata.json, which describes the folder of results as a research object (RO-Crate 1.1)."""

import mimetypes

from common.documents import yaml_reader
from common.files import sha256
from reports.inputs.reading import require_file, read_json

CRATE_CONTEXT, CRATE_PROFILE = "https://w3id.org/ro/crate/1.1/context", "https://w3id.org/ro/crate/1.1"
METADATA_FILE = "ro-crate-metadata.json"
MEDIA_TYPES = {".vtp": "application/x-vtk", ".vtu": "application/x-vtk", ".msh": "model/x-gmsh", ".stl": "model/stl"}
RUN_ID, PROGRAM_ID = "#study", "#vci"


def crate(results, cases, citation, date, cohort):
    """The document of ro-crate-metadata.json. Raises InputError if a file is missing.

    results: the folder that the document describes. cases: names of the study's cases. citation: path of CITATION.cff.
    date: date of the sources' git revision, in ISO 8601. Hashes of the cases' files are taken from provenance.json.
    All other hashes are computed here.
    """
    metadata = yaml_reader.read(citation).data
    provenance = read_json(results / "study" / "provenance.json", "workflow provenance")
    products = {
        f"cases/{case}/{name}": known for case in cases for name, known in provenance["cases"][case]["products"].items()
    }
    others = {name: sha256(results / name) for name in study_files(results, cases)}
    files = [file_entity(results, name, known) for name, known in sorted({**products, **others}.items())]
    inputs = {name: known for case in cases for name, known in provenance["cases"][case]["inputs"].items()}
    input_entities = [
        {"@id": f"#{name}", "@type": "CreativeWork", "name": name, "sha256": known} for name, known in inputs.items()
    ]
    title = f"{metadata['title']}: cohort {cohort}" if cohort else metadata["title"]
    software = provenance["software"]
    return {
        "@context": [CRATE_CONTEXT, {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}],
        "@graph": [
            {
                "@id": METADATA_FILE,
                "@type": "CreativeWork",
                "conformsTo": {"@id": CRATE_PROFILE},
                "about": {"@id": "./"},
            },
            {
                "@id": "./",
                "@type": "Dataset",
                "name": title,
                "description": metadata["abstract"],
                "keywords": metadata["keywords"],
                "datePublished": date,
                "license": {"@id": f"https://spdx.org/licenses/{metadata['license']}"},
                "citation": {"@id": article_entity(metadata)["@id"]},
                "mainEntity": {"@id": "report/index.html"},
                "mentions": {"@id": RUN_ID},
                "hasPart": [{"@id": entity["@id"]} for entity in files],
            },
            {
                "@id": RUN_ID,
                "@type": "CreateAction",
                "name": f"the study of {', '.join(cases)}",
                "instrument": {"@id": PROGRAM_ID},
                "object": [{"@id": entity["@id"]} for entity in input_entities],
                "result": [{"@id": "report/index.html"}, {"@id": "report/report.json"}],
            },
            {
                "@id": PROGRAM_ID,
                "@type": "SoftwareApplication",
                "name": metadata["title"],
                "version": f"{metadata['version']}, revision {software['revision']}",
                "operatingSystem": software["system"],
                "softwareRequirements": [f"{name} {version}" for name, version in software["packages"].items()],
            },
            {
                "@id": f"https://spdx.org/licenses/{metadata['license']}",
                "@type": "CreativeWork",
                "name": metadata["license"],
            },
            article_entity(metadata),
            *input_entities,
            *files,
        ],
    }


def article_entity(metadata):
    """The entity of the reproduced article, from CITATION.cff."""
    reference = metadata["references"][0]
    authors = [f"{author['family-names']}, {author['given-names']}" for author in reference["authors"]]
    return {
        "@id": f"https://doi.org/{reference['doi']}",
        "@type": "ScholarlyArticle",
        "name": reference["title"],
        "author": authors,
        "datePublished": str(reference["year"]),
    }


def study_files(results, cases):
    """Names, below `results`, of the report, the study's tables and the figures of the study and of these cases."""
    found = report_files(results / "report")
    found += sorted((results / "study").glob("*.*"))
    figures = sorted((results / "figures").glob("*.*"))
    of_others = {path.name for path in (results / "cases").glob("*") if path.name not in cases}
    found += [path for path in figures if not any(path.name.startswith(f"{case}_") for case in of_others)]
    return [str(require_file(path, "make study").relative_to(results)) for path in found]


def report_files(folder):
    """The files of the report, index and report.json first. Hidden files are left out: a killed run left them."""
    first = [folder / "index.html", folder / "report.json"]
    files = [path for path in sorted(folder.rglob("*")) if path.is_file() and path not in first]
    return first + [path for path in files if not any(part[0] == "." for part in path.relative_to(folder).parts)]


def file_entity(results, name, digest):
    """The RO-Crate entity of one file. name: its path below `results`; digest: its SHA-256."""
    path = require_file(results / name, "make study")
    media_type = MEDIA_TYPES.get(path.suffix) or mimetypes.guess_type(path.name)[0] or "application/octet-stream"
    size = str(path.stat().st_size)
    return {
        "@id": name,
        "@type": "File",
        "name": path.name,
        "encodingFormat": media_type,
        "contentSize": size,
        "sha256": digest,
    }
