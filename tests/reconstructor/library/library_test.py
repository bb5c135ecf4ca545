# SPDX-License-Identifier: Apache-2.0
"""The C++ library: a project outside the tree finds it where it was installed, and gets the colours of `render`.

SHEEN_BUILD is the build, SHEEN_GOLDEN the files of tests/golden, SHEEN_CONSUMER the project.
"""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy as np

import sheen

SPHERE = pathlib.Path(os.environ["SHEEN_GOLDEN"]) / "sphere.slf"


def run(*command, **more):
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, **more)


def first_hits(origin, directions, corners):
    """Triangle, u and v of what each ray meets first; -1 where nothing: Moeller and Trumbore (1997)."""
    a, b, c = np.moveaxis(corners, 1, 0)
    hits = []
    for direction in directions:
        across = np.cross(direction, c - a)
        det = np.einsum("ij,ij->i", b - a, across)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.einsum("ij,ij->i", origin - a, across) / det
            q = np.cross(origin - a, b - a)
            v = q @ direction / det
            t = np.einsum("ij,ij->i", q, c - a) / det
        inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
        nearest = np.argmin(np.where(inside, t, np.inf))
        hits.append((nearest, u[nearest], v[nearest]) if inside[nearest] else (-1, 0, 0))
    return hits


class Library(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        shutil.copytree(os.environ["SHEEN_CONSUMER"], cls.folder / "source")
        prefix, build = cls.folder / "prefix", cls.folder / "build"
        for command in (["cmake", "--install", os.environ["SHEEN_BUILD"], "--component", "library", "--prefix", prefix],
                        ["cmake", "-S", cls.folder / "source", "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}"],
                        ["cmake", "--build", build]):
            done = run(*command)
            assert done.returncode == 0, done.stdout + done.stderr
        cls.prefix, cls.program = prefix, build / "consumer"

    def test_colours_are_those_of_render(self):
        model = sheen.open(SPHERE)
        low, high = model.bounds
        centre, size = (low + high) / 2, np.linalg.norm(high - low)
        eye, side = centre + size * np.array([0.3, -1.1, 0.6]), 24
        picture = model.render(eye=eye, target=centre, up=(0, 0, 1), field_of_view=50, width=side, height=side)
        forward = (centre - eye) / np.linalg.norm(centre - eye)
        right = np.cross(forward, (0, 0, 1))
        right /= np.linalg.norm(right)
        down = np.cross(forward, right)
        at = (np.arange(side) - (side - 1) / 2) * np.tan(np.radians(25)) / (side / 2)
        directions = (forward + at[None, :, None] * right + at[:, None, None] * down).reshape(-1, 3)
        vertices, triangles = model.mesh()
        hits = first_hits(eye, directions, vertices[triangles])
        inside = [i for i, hit in enumerate(hits) if hit[0] >= 0 and picture.reshape(-1, 4)[i, 3] == 1]
        self.assertGreater(len(inside), 30)
        asked = "".join("%d %.9g %.9g\n" % hits[i] for i in inside)
        done = run(self.program, SPHERE, *eye, input=asked)
        self.assertEqual(done.returncode, 0, done.stderr)
        theirs = np.array([line.split() for line in done.stdout.splitlines()], float)
        np.testing.assert_allclose(theirs, picture.reshape(-1, 4)[inside, :3], atol=2e-4)
        self.assertGreater(theirs.std(), 0.01)

    def test_what_is_wrong_is_told(self):
        for path in ("/nowhere/model.slf", self.folder / "source" / "main.cpp"):
            done = run(self.program, path, 1, 0, 0)
            self.assertEqual(done.returncode, 1)
            self.assertIn(str(path), done.stderr)
        done = run(self.program, SPHERE, 1, 0, 0, input="4000000000 0 0\n")
        self.assertEqual(done.returncode, 1)
        self.assertIn("no triangle 4000000000", done.stderr)

    def test_it_stands_by_itself(self):
        needed = run("ldd", self.program).stdout
        for heavy in ("opencv", "embree", "tbb", "protobuf"):
            self.assertNotIn(heavy, needed)
        header = (self.prefix / "include/sheen/light_field.h").read_text()
        self.assertNotRegex(header, r'#include (?!<(array|cstdint|memory|string|vector)>)')


if __name__ == "__main__":
    unittest.main()
