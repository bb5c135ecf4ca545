# SPDX-License-Identifier: Apache-2.0
"""The Python module against the program: the same pictures, the same messages.

SHEEN_PROGRAM and SHEEN_GOLDEN say where sheen-reconstructor and the files of tests/golden are.
"""
import ast
import inspect
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import threading
import unittest
import zlib

import numpy as np

import sheen

PROGRAM = os.environ["SHEEN_PROGRAM"]
GOLDEN = pathlib.Path(os.environ["SHEEN_GOLDEN"])
SPHERE, RELIEF, VIEWS = (GOLDEN / name for name in ("sphere.slf", "relief.rif", "views.ilg"))
LUMIGRAPH = "intrinsic lumigraph"  # "format" of its folder


def run(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)


def read_png(path):
    """Pixels of an 8-bit PNG without interlacing, by the standard: (height, width, channels)."""
    data = pathlib.Path(path).read_bytes()
    packed, at = b"", 8
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, bits, colour = struct.unpack(">IIBB", body[:10])
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    assert bits == 8
    channels = {0: 1, 2: 3, 4: 2, 6: 4}[colour]
    raw = zlib.decompress(packed)
    stride = width * channels
    rows = np.zeros((height + 1, channels + stride), int)  # what is left of and above the picture is 0
    for y in range(height):
        method, line = raw[y * (stride + 1)], raw[y * (stride + 1) + 1 : (y + 1) * (stride + 1)]
        above, row = rows[y], rows[y + 1]
        for i, value in enumerate(line, channels):
            left, up, corner = row[i - channels], above[i], above[i - channels]
            nearest = min((left, up, corner), key=lambda each: abs(left + up - corner - each))
            row[i] = value + (0, left, up, (left + up) // 2, nearest)[method] & 255
    return rows[1:, channels:].reshape(height, width, channels).astype(np.uint8)


def look_at(eye, target, up):
    """camera_from_object of a camera, by the definition: OpenCV axes."""
    eye, target, up = (np.asarray(v, float) for v in (eye, target, up))
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = [right, np.cross(forward, right), forward]
    pose[:3, 3] = -pose[:3, :3] @ eye
    return pose


def srgb(linear):
    linear = np.clip(linear, 0, 1)
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def write_png(path, pixels):
    """8 bits, RGB."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def write_box(path):
    """A cube of 0.2 m."""
    corners = 0.1 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = "".join(f"3 {a} {b} {c}\n3 {a} {c} {d}\n" for a, b, c, d in quads)
    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 12\nproperty list uchar int vertex_indices\nend_header\n" +
        "".join("%g %g %g\n" % tuple(each) for each in corners) + faces)


def lumigraph(folder):
    """A saved intrinsic lumigraph: the views of tests/golden, on another mesh."""
    folder.mkdir()
    write_box(folder / "mesh.ply")
    (folder / "views.ilg").write_bytes(VIEWS.read_bytes())
    (folder / "model.json").write_text(json.dumps({"format": LUMIGRAPH, "views": "views.ilg", "mesh": "mesh.ply"}))
    return folder


def photographs_of_a_box(folder):
    """A data set: 24 photographs of a cube of 0.2 m whose faces have smooth colours, and its mesh."""
    folder.mkdir()
    write_box(folder / "mesh.ply")
    width, height, focal = 96, 72, 100.0
    v, u = np.mgrid[:height, :width]
    rays = np.stack([(u - (width - 1) / 2) / focal, (v - (height - 1) / 2) / focal, np.ones((height, width))], axis=-1)
    frames = []
    for i in range(24):
        around, up = 2 * math.pi * i / 24, 0.6 * math.sin(2.1 * i)
        eye = 0.55 * np.array([math.cos(around) * math.cos(up), math.sin(around) * math.cos(up), math.sin(up)])
        pose = look_at(eye, (0, 0, 0), (0, 0, 1))
        directions = rays @ pose[:3, :3]
        with np.errstate(divide="ignore", invalid="ignore"):
            near, far = (-0.1 * np.sign(directions) - eye) / directions, (0.1 * np.sign(directions) - eye) / directions
        enter, leave = near.max(axis=-1), far.min(axis=-1)
        place = eye + enter[..., None] * directions
        colours = 130 + 70 * np.sin(np.stack([30 * place[..., 0] + 20 * place[..., 1], 25 * place[..., 1] - 1,
                                              28 * place[..., 2] + 10 * place[..., 0]], axis=-1))
        pixels = np.where((enter < leave)[..., None], colours, 0)
        write_png(folder / f"{i:02}.png", pixels.round().astype(np.uint8))
        frames.append({"file_path": f"{i:02}.png",
                       "transform_matrix": (np.linalg.inv(pose) @ np.diag([1.0, -1, -1, 1])).tolist()})
    (folder / "transforms.json").write_text(json.dumps(
        {"w": width, "h": height, "fl_x": focal, "fl_y": focal, "cx": width / 2, "cy": height / 2, "frames": frames}))
    return folder


class Rendered(unittest.TestCase):
    """Pictures are those of the program."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def program_renders(self, model, *arguments):
        out = self.folder / "out"
        done = run("render", model, *arguments, "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [read_png(file) for file in sorted(out.glob("**/*.png"))]

    def transforms(self, poses, k, width, height, **more):
        flip = np.diag([1.0, -1, -1, 1])
        frames = [{"file_path": f"{i}.png", "transform_matrix": (np.linalg.inv(pose) @ flip).tolist(), **more}
                  for i, pose in enumerate(poses)]
        file = self.folder / "transforms.json"
        file.write_text(json.dumps({"w": width, "h": height, "fl_x": k[0][0], "fl_y": k[1][1], "cx": k[0][2] + 0.5,
                                    "cy": k[1][2] + 0.5, "frames": frames}))
        return file

    def around(self, model):
        """An eye, a target, an up direction from which the object fills about half of the picture."""
        low, high = model.bounds
        centre, size = (low + high) / 2, np.linalg.norm(high - low)
        return centre + size * np.array([1.2, 0.5, 0.8]), centre, np.array([0.0, 0, 1])

    def test_a_view_from_an_eye(self):
        model = sheen.open(SPHERE)
        eye, target, up = self.around(model)
        keys = [{"eye": eye.tolist(), "target": target.tolist(), "up": up.tolist()},
                {"eye": (eye + 0.1).tolist(), "target": target.tolist(), "up": up.tolist()}]
        file = self.folder / "keys.json"
        file.write_text(json.dumps({"keys": keys, "fov_deg": 35}))
        theirs = self.program_renders(SPHERE, "--path", file, "--frames", 2, "--size", "200x150")[0]
        ours = model.render_srgb8(eye=eye, target=target, up=up, field_of_view=35, width=200, height=150)
        np.testing.assert_array_equal(ours, theirs)
        self.assertGreater((ours[..., 3] == 255).mean(), 0.1)
        self.assertGreater((ours[..., 3] == 0).mean(), 0.1)

    def test_a_camera_by_its_matrices(self):
        for path in (SPHERE, lumigraph(self.folder / "lumigraph")):
            with self.subTest(path=path.name):
                model = sheen.open(path)
                k = [[150, 0, 99.25], [0, 140.5, 60], [0, 0, 1]]
                pose = look_at(*self.around(model))
                cameras = self.transforms([pose], k, 180, 130)
                theirs = self.program_renders(path, "--cameras", cameras)[0]
                ours = model.render_srgb8(intrinsics=k, camera_from_object=pose, width=180, height=130)
                apart = np.abs(ours.astype(int) - theirs)  # the pose goes through text and back: its last bits differ
                self.assertLessEqual(apart.max(), 1)
                self.assertGreater((ours[..., 3] > 0).mean(), 0.05)

    def test_lights(self):
        model = sheen.open(RELIEF)
        self.assertNotEqual(model.light_kind, "fixed")
        lights = model.lights[[0, len(model.lights) // 2, -1]]
        file = self.folder / "lights.lp"
        file.write_text("3\n" + "".join(f"{i}.png {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(lights.tolist())))
        theirs = self.program_renders(RELIEF, "--lights", file)
        self.assertEqual(len(theirs), 3)
        for light, picture in zip(lights, theirs):
            ours = model.render_srgb8(light=light)
            inside = ours[..., 3] == 255
            self.assertGreater(inside.mean(), 0.8)
            np.testing.assert_array_equal(ours[inside][:, :3], picture[inside][:, :3])
        self.assertGreater(np.abs(theirs[0].astype(int) - theirs[1]).max(), 5)

    def test_the_first_view_shows_all_of_the_object(self):
        model = sheen.open(SPHERE)
        alpha = model.render(width=160, height=120)[..., 3]
        for edge in (alpha[0], alpha[-1], alpha[:, 0], alpha[:, -1]):
            self.assertEqual(edge.max(), 0)
        self.assertGreater((alpha.max(axis=1) > 0).sum(), 95)

    def test_linear_and_srgb_are_one_picture(self):
        model = sheen.open(SPHERE)
        linear, codes = model.render(width=160, height=120), model.render_srgb8(width=160, height=120)
        self.assertEqual((linear.dtype, linear.shape), (np.float32, (120, 160, 4)))
        self.assertEqual((codes.dtype, codes.shape), (np.uint8, (120, 160, 4)))
        alpha = linear[..., 3:]
        shown = alpha[..., 0] > 0
        self.assertLess(np.abs(255 * alpha - codes[..., 3:]).max(), 0.51)
        straight = srgb(linear[shown][:, :3] / alpha[shown])
        self.assertLess(np.abs(straight - codes[shown][:, :3]).max(), 0.51)
        self.assertEqual(np.abs(linear[~shown]).max(), 0)

    def test_cameras_of_the_images(self):
        model = sheen.open(SPHERE)
        self.assertEqual(len(model.cameras), model.images)
        camera = model.cameras[1]
        self.assertEqual(camera.distortion.shape, (5,))
        side = dict(width=camera.width // 4, height=camera.height // 4)
        seen = model.render(camera=camera, **side)
        self.assertEqual(seen.shape, (side["height"], side["width"], 4))
        if not camera.distortion.any():
            k = np.diag([0.25, 0.25, 1]) @ camera.intrinsics
            k[:2, 2] = (camera.intrinsics[:2, 2] + 0.5) / 4 - 0.5
            again = model.render(intrinsics=k, camera_from_object=camera.camera_from_object, **side)
            np.testing.assert_allclose(again, seen, atol=1e-3)
        self.assertEqual(model.render(camera=camera).shape, (camera.height, camera.width, 4))
        with self.assertRaisesRegex(sheen.ConfigError, "camera"):
            model.render(camera=camera, eye=(1, 0, 0), target=(0, 0, 0))

    def test_layers(self):
        model = sheen.open(SPHERE)
        eye, target, up = self.around(model)
        view = dict(eye=eye, target=target, up=up, width=60, height=45)
        layers = model.render_layers(["depth", "normals"], **view)
        self.assertEqual({name: each.shape for name, each in layers.items()},
                         {"depth": (45, 60, 1), "normals": (45, 60, 3)})
        depth, normals = layers["depth"][..., 0], layers["normals"]
        shown = np.isfinite(depth)
        self.assertGreater(shown.mean(), 0.1)
        self.assertLess(abs(depth[shown].min() - (np.linalg.norm(eye - target) - 0.09)), 0.01)  # a sphere of 0.09 m
        np.testing.assert_allclose(np.linalg.norm(normals[shown], axis=-1), 1, atol=1e-3)
        self.assertEqual(model.render_layers([], **view), {})
        for words, names in (("layers", ["colour"]), ("shadow", ["shadow"])):
            with self.assertRaisesRegex(sheen.ConfigError, words):
                model.render_layers(names, **view)

    def test_threads_get_the_same_picture(self):
        model = sheen.open(SPHERE)
        pictures = []
        threads = [threading.Thread(target=lambda: pictures.append(model.render(width=100, height=80)))
                   for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(pictures), 4)
        for picture in pictures:
            np.testing.assert_array_equal(picture, pictures[0])


class Described(unittest.TestCase):
    """What a model says of itself."""

    def test_kinds(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        views = lumigraph(pathlib.Path(folder.name) / "lumigraph")
        kinds = {SPHERE: "surface_light_field", RELIEF: "irradiance_field", views: "intrinsic_lumigraph"}
        for path, kind in kinds.items():
            with self.subTest(path=path.name):
                model = sheen.open(str(path))
                self.assertEqual(model.kind, kind)
                self.assertEqual(model.path, path)
                self.assertGreater(model.images, 1)
                self.assertIsInstance(model.metadata, dict)
                self.assertIn("images", repr(model))

    def test_mesh_and_bounds(self):
        model = sheen.open(SPHERE)
        vertices, triangles = model.mesh()
        self.assertEqual((vertices.dtype, vertices.shape[1]), (np.float64, 3))
        self.assertEqual((triangles.dtype, triangles.shape[1]), (np.uint32, 3))
        self.assertLess(triangles.max(), len(vertices))
        np.testing.assert_array_equal(model.bounds, [vertices.min(axis=0), vertices.max(axis=0)])
        corners = vertices[triangles]
        volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
        self.assertGreater(volume, 0)  # seen from outside they are counter-clockwise

    def test_types_and_texts(self):
        stub = ast.parse((pathlib.Path(sheen.__file__).parent / "__init__.pyi").read_text())
        typed = {node.name: node for node in stub.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
        self.assertEqual(sorted(typed), sorted(sheen.__all__))
        for kind in (sheen.Camera, sheen.Model):
            self.check_members(kind, typed[kind.__name__])
        self.assertTrue((pathlib.Path(sheen.__file__).parent / "py.typed").exists())

    def check_members(self, kind, typed):
        members = {node.name: node for node in typed.body if isinstance(node, ast.FunctionDef)}
        public = [name for name in dir(kind) if not name.startswith("_")]
        self.assertEqual(sorted(members), sorted(public))
        for name, node in members.items():
            member = getattr(kind, name)
            self.assertTrue(member.__doc__, name)
            if callable(member):
                said = list(inspect.signature(member).parameters)
                self.assertEqual(said, [each.arg for each in node.args.args[1:] + node.args.kwonlyargs], name)


class Worked(unittest.TestCase):
    """The work of the commands."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.data = photographs_of_a_box(cls.folder / "data")
        cls.model = cls.folder / "box.slf"
        cls.report = sheen.build(cls.data, mesh=cls.data / "mesh.ply", out=cls.model, hold_out=6, refine=False)

    def test_build_and_evaluate(self):
        self.assertEqual(self.report["frames"]["held_out"], 4)
        model = sheen.open(self.model)
        self.assertEqual(model.images, 20)
        scores = model.evaluate(self.data)
        self.assertEqual(len(scores["views"]), 4)
        self.assertGreater(scores["object"]["psnr_db"], 25)
        told = self.folder / "report.json"
        done = run("evaluate", self.model, self.data, "--json", told)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(scores["object"], json.loads(told.read_text())["object"])

    def test_export(self):
        model = sheen.open(self.model)
        report = model.export(self.folder / "box.glb")
        self.assertEqual((self.folder / "box.glb").read_bytes()[:4], b"glTF")
        self.assertEqual(report["gltf"]["triangles"], len(model.mesh()[1]))
        run("export", self.model, "--gltf", self.folder / "theirs.glb")
        self.assertEqual((self.folder / "box.glb").read_bytes(), (self.folder / "theirs.glb").read_bytes())
        model.export(self.folder / "surface", form="ply")
        self.assertEqual((self.folder / "surface").read_bytes()[:3], b"ply")
        with self.assertRaisesRegex(sheen.ConfigError, "relief.rif"):
            sheen.open(RELIEF).export(self.folder / "splats.ply", form="splats")
        with self.assertRaisesRegex(sheen.ConfigError, "its ending says no form"):
            model.export(self.folder / "box.fbx")
        with self.assertRaisesRegex(sheen.ConfigError, "form"):
            model.export(self.folder / "box.glb", form="fbx")
        with self.assertRaisesRegex(sheen.ConfigError, "relight"):
            model.export(self.folder / "box.ptm")

    def test_the_notebook(self):
        work = self.folder / "notebook"
        work.mkdir()
        (work / "photographs").symlink_to(self.data)
        cells = json.loads(pathlib.Path(os.environ["SHEEN_NOTEBOOK"]).read_text())["cells"]
        code = ["".join(cell["source"]) for cell in cells
                if cell["cell_type"] == "code" and "matplotlib" not in cell["metadata"].get("tags", ())]
        self.assertGreater(len(code), 4)
        done = subprocess.run([sys.executable, "-c", "\n".join(code)], cwd=work, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("light field", done.stdout)

    def test_what_is_wrong(self):
        for words, arguments in (("hold_out", dict(hold_out=-1)), ("--model", dict(model="no_such")),
                                 ("--favour", dict(favour="cheap")), ("--refine", dict(refine="all")),
                                 ("bytes and loss", dict(bytes="1MB", loss="1dB")), ("--loss", dict(loss="much"))):
            with self.subTest(arguments=arguments), self.assertRaisesRegex(sheen.ConfigError, words):
                sheen.build(self.data, mesh=self.data / "mesh.ply", **arguments)
        with self.assertRaisesRegex(sheen.FileError, "no_mesh.ply"):
            sheen.build(self.data, mesh=self.folder / "no_mesh.ply")
        with self.assertRaisesRegex(sheen.FileError, "no such|there is no|cannot"):
            sheen.open(self.model).evaluate(self.folder / "nowhere")

    def test_ctrl_c_ends_it(self):
        script = f"""
import os, signal, threading, sheen
threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    for _ in range(1000):
        sheen.build({str(self.data)!r}, mesh={str(self.data / "mesh.ply")!r}, out={str(self.folder / "not.slf")!r})
        os.unlink({str(self.folder / "not.slf")!r})
except KeyboardInterrupt:
    print("interrupted")
sheen.open({str(self.model)!r}).evaluate({str(self.data)!r})  # the next work does not take that for its own
print("went on")
"""
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=100)
        self.assertEqual(done.stdout.split("\n")[:2], ["interrupted", "went on"], done.stderr)


class Refused(unittest.TestCase):
    """What is wrong is an exception with the program's message."""

    def test_no_model(self):
        with self.assertRaises(sheen.FileError) as raised:
            sheen.open("/nowhere/model.slf")
        self.assertIsInstance(raised.exception, OSError)
        self.assertIsInstance(raised.exception, sheen.Error)
        with tempfile.TemporaryDirectory() as folder:
            done = run("render", "/nowhere/model.slf", "--turntable", 2, "--out", folder)
        self.assertIn(str(raised.exception), done.stderr)

    def test_damaged_model(self):
        with tempfile.TemporaryDirectory() as folder:
            damaged = pathlib.Path(folder) / "half.slf"
            damaged.write_bytes(SPHERE.read_bytes()[:1000])
            with self.assertRaisesRegex(sheen.FileError, "half.slf"):
                sheen.open(damaged)
            os.symlink(damaged, os.path.join(os.fsencode(folder), b"\xff.slf"))
            with self.assertRaisesRegex(sheen.FileError, r"\\xff.slf"):
                sheen.open(os.path.join(os.fsencode(folder), b"\xff.slf"))

    def test_arguments(self):
        model = sheen.open(SPHERE)
        eye, target = (1, 0, 0), (0, 0, 0)
        k, pose = np.diag([100.0, 100, 1]), look_at((1, 0, 0), (0, 0, 0), (0, 0, 1))
        wrong = [
            ("eye and target", dict(eye=eye)),
            ("eye and target", dict(field_of_view=30)),
            ("looks nowhere", dict(eye=eye, target=eye)),
            ("looks nowhere", dict(eye=eye, target=target, up=(2, 0, 0))),
            ("looks nowhere", dict(eye=eye, target=target, up=(0, 0, 0))),
            ("eye", dict(eye=(math.nan, 0, 0), target=target)),
            ("target", dict(eye=eye, target=(math.inf, 0, 0))),
            ("field_of_view", dict(eye=eye, target=target, field_of_view=0)),
            ("field_of_view", dict(eye=eye, target=target, field_of_view=math.nan)),
            ("not both", dict(eye=eye, target=target, intrinsics=k, camera_from_object=pose)),
            ("camera_from_object", dict(intrinsics=k)),
            ("intrinsics", dict(camera_from_object=pose)),
            ("intrinsics", dict(intrinsics=np.ones((3, 3)), camera_from_object=pose)),
            ("fx", dict(intrinsics=np.diag([-1.0, 100, 1]), camera_from_object=pose)),
            ("camera_from_object", dict(intrinsics=k, camera_from_object=2 * pose)),
            ("camera_from_object", dict(intrinsics=k, camera_from_object=np.diag([1.0, 1, -1, 1]))),
            ("camera_from_object", dict(intrinsics=k, camera_from_object=math.nan * pose)),
            ("width and height", dict(width=0)),
            ("width", dict(width=1 << 20)),
            ("light", dict(light=(0, 0, 1))),
        ]
        for words, arguments in wrong:
            with self.subTest(arguments=arguments), self.assertRaisesRegex(sheen.ConfigError, words) as raised:
                model.render(**arguments)
            self.assertIsInstance(raised.exception, ValueError)
        with self.assertRaises(TypeError):
            model.render(eye=(1, 2), target=target)
        with self.assertRaisesRegex(sheen.ConfigError, "light"):
            sheen.open(RELIEF).render(light=(0, 0, 0) if sheen.open(RELIEF).light_kind == "directional" else (math.nan, 0, 0))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "--verbose", *sys.argv[1:]])
