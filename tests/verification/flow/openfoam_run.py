"""Runs the programs of Debian's package `openfoam` and reads and writes a case's files, for a tube and for a tree."""

import os
import re
import shutil
import subprocess

import numpy as np

from common.errors import ComputationError

PROGRAMS = ("gmshToFoam", "transformPoints", "polyDualMesh", "renumberMesh", "checkMesh", "simpleFoam")
HEADER = "FoamFile { version 2.0; format ascii; class %s; object %s; }\n"


def missing_programs():
    """Names of the programs that are not installed."""
    return [name for name in PROGRAMS if shutil.which(name) is None]


def write(path, kind, text):
    """Writes a file of a case; kind: the class that OpenFOAM's file header names."""
    path.write_text(HEADER % (kind, path.name) + text)


def children_cpu_seconds():
    """CPU seconds of the child processes that have ended."""
    return sum(os.times()[2:4])


def cpu_seconds():
    """CPU seconds of this process and of the child processes that have ended."""
    return sum(os.times()[:4])


def run_program(folder, *command):
    """Runs a program in the case's folder and returns its output, which is also kept as log.<program>."""
    environment = {**os.environ, "WM_PROJECT_DIR": "/usr/share/openfoam", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, cwd=folder, env=environment, text=True, capture_output=True)
    (folder / f"log.{command[0]}").write_text(done.stdout + done.stderr)
    if done.returncode != 0:
        raise ComputationError(f"{command[0]} failed", str(folder), f"exit code {done.returncode}", "see its log")
    return done.stdout


NUMBER = r"([-+.eE\d]+)"
POINT = re.compile(rf"^\({NUMBER} {NUMBER} {NUMBER}\)$", re.M)


def points_of(folder):
    """Points (n, 3) of the mesh in m, from its file in ASCII."""
    return np.array(POINT.findall((folder / "constant" / "polyMesh" / "points").read_text()), float)


def faces(folder, patch):
    """The faces of a patch, each as an array of its points' numbers."""
    mesh = folder / "constant" / "polyMesh"
    entry = re.search(patch + r"\s*{(.*?)}", (mesh / "boundary").read_text(), re.S).group(1)
    count, start = (int(re.search(rf"{key}\s+(\d+)", entry).group(1)) for key in ("nFaces", "startFace"))
    faces = re.findall(r"\d+\s*\(([\d\s]+)\)", (mesh / "faces").read_text())[start : start + count]
    return [np.array(face.split(), int) for face in faces]


def inlet_faces(folder):
    """Area vectors (m2) and centres (m) of the inlet's faces."""
    points, areas, centres = points_of(folder), [], []
    for face in faces(folder, "inlet"):
        corners = points[face]
        middle = corners.mean(axis=0)
        parts = 0.5 * np.cross(corners - middle, np.roll(corners, -1, axis=0) - middle)
        size = np.linalg.norm(parts, axis=1)
        areas.append(parts.sum(axis=0))
        centres.append((((corners + np.roll(corners, -1, axis=0) + middle) / 3) * size[:, None]).sum(0) / size.sum())
    return np.array(areas), np.array(centres)


def polyhedra(folder, tetrahedra, moved=lambda folder: None):
    """Turns a gmsh file (format 2.2, mm, in the case's folder) into the case's polyhedra.

    moved: called with the folder before the cells are renumbered; may move the points.
    """
    run_program(folder, "gmshToFoam", tetrahedra)
    boundary = folder / "constant" / "polyMesh" / "boundary"
    boundary.write_text(re.sub(r"(wall\s*{\s*type\s*)patch", r"\1wall", boundary.read_text()))
    run_program(folder, "transformPoints", "-scale", "(0.001 0.001 0.001)")
    run_program(folder, "polyDualMesh", "60", "-overwrite", "-concaveMultiCells")
    moved(folder)
    run_program(folder, "renumberMesh", "-overwrite")


def figures(folder):
    """{cells, volume_mm3} by checkMesh. Raises ComputationError for cells of negative volume."""
    return figures_of_output(run_program(folder, "checkMesh"), folder)


def figures_of_output(checked, folder):
    """The result of `figures`, from the output of checkMesh."""
    bad = re.search(r"Number of negative volume cells: (\d+)", checked)
    if bad:
        remedy = "take a finer mesh: its curved cells are nearer to straight ones"
        raise ComputationError("polyhedra of no positive volume", str(folder), bad.group(1), remedy)
    return {
        "cells": int(re.search(r"cells:\s+(\d+)", checked).group(1)),
        "volume_mm3": 1e9 * float(re.search(r"Total volume = ([-+.eE\d]+?)\.? ", checked).group(1)),
    }
