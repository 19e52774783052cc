"""The real surfaces of the shared data, from the file to the volume mesh of the deployed lumen, as a table.

Run: /usr/bin/python3 tests/verification/anatomy/real_table.py --out FOLDER [--build build]. FOLDER/real.md has a row of
each surface: its ends, worst lesion, plan by `plan: auto`, the first step that was refused, or the tetrahedra of the
mesh, and CPU seconds. Each surface keeps its folder with all files.
"""

import argparse
import json
import pathlib

import campaign
import campaign_steps

HEAD = "| surface | ends | worst lesion | plan | mesh of the deployed lumen | CPU s: anatomy, all |\n"
HEAD += "| --- | --- | --- | --- | --- | --- |\n"


def ends_of(summary, expected):
    """Number of ends, with the true number where it differs."""
    found = len(summary["ends"])
    return str(found) if found == expected else f"{found} of {expected}"


def lesion_of(summary):
    """Stenosis, smallest area and place of the worst lesion."""
    if not summary["lesions"]:
        return "none"
    worst = summary["lesions"][0]
    text = f"{worst['diameter_stenosis_percent']:.1f} %, {worst['mla_mm2']:.2f} mm²"
    return text if worst["branch"] == "main" else f"{text} on {worst['branch']}"


def plan_of(plan):
    """The devices of a plan in the order of its steps, and the number of its remarks."""
    used = [one["device"] for step in plan["procedure"] for one in step["devices"]]
    remarks = len(plan["reference"].get("remarks", []))
    return ", ".join(name.replace("_", " ") for name in used) + (
        f"; {remarks} remark{'s' * (remarks > 1)}" if remarks else ""
    )


def row_of(surface, ends, folder, build):
    """The row of one surface; its files stay in `folder`."""
    folder.mkdir(parents=True)
    case = folder / "case.yaml"
    case.write_text(campaign_steps.CASE.format(name=surface.stem, path=surface))
    code, reason, first = campaign.run([build / "lumen", "process", surface, "--out", folder / "anatomy"])
    if code:
        return [surface.stem, "", "", f"anatomy: {reason}", "", f"{first:.1f}"]
    summary = json.loads((folder / "anatomy" / "anatomy.json").read_text())
    total, plan, mesh = first, "", ""
    for step, command in campaign_steps.steps_of(case, folder, build):
        code, reason, seconds = campaign.run(command)
        total += seconds
        if code and step == "plan":
            plan = f"refused: {reason}"
        elif code:
            mesh = f"{step}: {reason}"
        if code:
            break
        if step == "plan":
            plan = plan_of(json.loads((folder / "vci" / "plan.json").read_text()))
        elif step == "volume mesh":
            made = json.loads((folder / "mesh.json").read_text())
            mesh = f"{made['cells']} tetrahedra, {made['swept']['cells']} of them swept"
    return [surface.stem, ends_of(summary, ends), lesion_of(summary), plan, mesh, f"{first:.1f}, {total:.0f}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=campaign.build_folder())
    parser.add_argument("--out", type=pathlib.Path, required=True)
    options = parser.parse_args()
    rows = []
    for surface, ends in campaign_steps.real_surfaces():
        rows.append(row_of(surface, ends, options.out.resolve() / surface.stem, options.build.resolve()))
        print("|", " | ".join(rows[-1]), "|", flush=True)
    (options.out / "real.md").write_text(HEAD + "".join(f"| {' | '.join(row)} |\n" for row in rows))


if __name__ == "__main__":
    main()
