// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen::words {

// What help() says. A function's text begins with its signature, in the form that Python's `inspect` reads.

inline constexpr const char* kModule =
    "Sheen's models of how an object looks: opened, drawn, measured, built, exported.";

inline constexpr const char* kOpen = R"(open(path)
--

Opens a saved model, a file (.slf, .rif) or a folder: a `Model`.

Raises FileError where there is none, or it is damaged.)";

inline constexpr const char* kModel = R"(A saved model; `sheen.open` opens it.

Lengths are in metres and places in the frame of the mesh that the model was built on.
Several threads may use one model at once.)";

inline constexpr const char* kRender =
    R"(render($self, *, eye=None, target=None, up=None, field_of_view=None, intrinsics=None, camera_from_object=None, camera=None, width=None, height=None, light=None)
--

The picture of a camera, linear: float32 of (height, width, 4), red, green, blue and alpha.

Colours are linear radiance times alpha, as `sheen-reconstructor render` writes them into OpenEXR files; alpha is the part
of a pixel that shows the surface. The camera is given in one of three ways, or not at all: then it is the model's own, or
one that shows all of the object from the side that most images were taken from.

eye, target, up: (3,), from where to where the camera looks, and what is up in its picture (default: as in the images).
field_of_view: degrees from the picture's lower to its upper edge, 1 to 150 (default 40).

intrinsics: (3, 3), [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels; integer coordinates are the middles of pixels.
camera_from_object: (4, 4), from the object's frame to the camera's: x right, y down, z forward (OpenCV).

camera: one of `cameras`, with its lens; width and height give its picture another size.

width, height: pixels (default 640 x 480, or the camera's).
light: (3,), where `light_kind` is "point" the lamp's place, where it is "directional" the direction to it (default: the
first light of the images).

Raises ConfigError naming the argument that is wrong.)";

inline constexpr const char* kRenderSrgb8 =
    R"(render_srgb8($self, *, eye=None, target=None, up=None, field_of_view=None, intrinsics=None, camera_from_object=None, camera=None, width=None, height=None, light=None)
--

The same picture for a screen: uint8 of (height, width, 4), sRGB and linear alpha, colours not multiplied by it.

These are the bytes of the PNG files of `sheen-reconstructor render`. Arguments as of `render`.)";

inline constexpr const char* kRenderLayers =
    R"(render_layers($self, layers, *, eye=None, target=None, up=None, field_of_view=None, intrinsics=None, camera_from_object=None, camera=None, width=None, height=None, light=None)
--

What else is in a picture's pixels: a dict of float32 arrays of (height, width, channels).

layers: names out of "depth" (metres along the camera's axis, infinite where nothing is), "normals" (x, y, z in the
camera's axes), and of an intrinsic lumigraph "reflectance", "illumination" and "shadow"; as `render --layers` writes
them. Other arguments as of `render`.)";

inline constexpr const char* kMesh = R"(mesh($self)
--

The surface: vertices, float64 of (n, 3), and triangles, uint32 of (m, 3): indices of vertices, counter-clockwise seen
from outside.)";

inline constexpr const char* kEvaluate = R"(evaluate($self, dataset, *, baselines=False, truth=None, object=None)
--

Measures the model on images that it never saw: the report of `sheen-reconstructor evaluate`, a dict.

dataset: the images it was built from, and the held-out ones: a folder of a data set or a session; of a model of moving
light a list of lights (.lp) that it never saw.
baselines: also of what stores photographs, on the same pixels.
truth: folder of NAME.exr to score against, not against the images.
object: mesh whose pixels count, where it is not the model's.

report["object"] has the means over report["views"], "psnr_db" and "ssim" on the pixels of the object.)";

inline constexpr const char* kExport = R"(export($self, path, form=None)
--

Writes the model for other programs: the report of `sheen-reconstructor export`, a dict.

form: "gltf", "ply", "obj" or "usdz", the mesh with its mean look; "splats", a light field as Gaussians (PLY); "relight",
an irradiance field as polynomials; "page", a folder, or "single", a file, that shows the model in a browser. By default
the ending of `path` says it: .glb, .ply (the mesh), .obj, .usdz, .ptm or .html, or none for a page.

A line on standard output says what was written.)";

inline constexpr const char* kBuild =
    R"(build(dataset, *, mesh=None, out=None, model=None, config=None, refine=None, hold_out=None, budget=None, target=None, memory=None, tolerance=None, bytes=None, loss=None, favour=None)
--

Builds a model from photographs with poses, or a session, and saves it: the report of `sheen-reconstructor build`, a
dict.

dataset: folder with transforms.json, a COLMAP model or a session, or a list of lights (.lp).
mesh: PLY, OBJ or OFF in the data set's frame; a model that makes its own surface needs none.
out: file to save the model to, or with loss="0dB" a folder; without it the model is judged and not kept.
model: "surface_light_field" (default), "irradiance_field", "intrinsic_lumigraph", or "auto": by what moves.
config: scene file (TOML), in place of `model`.
refine: False: the mesh as it is; True or "mesh", "poses": corrected first; None: where it gains.
hold_out: every so many images is held out where the data set names none; 0: none.
budget, target, memory, tolerance: texts such as "33ms", "35dB", "1GB", "0.01".
bytes, loss: how small the file is to be, such as "2MB", or what it may lose, such as "0.1dB".
favour: "speed", "accuracy" or "size", for those of these that are not given.

Progress goes to standard error. Ctrl-C ends it: KeyboardInterrupt, and nothing is written.)";

inline constexpr const char* kPath = "Where it was opened from: a pathlib.Path.";
inline constexpr const char* kKind = "\"surface_light_field\", \"irradiance_field\" or \"intrinsic_lumigraph\".";
inline constexpr const char* kImages = "How many images it was made of.";
inline constexpr const char* kMetadata = "What was noted when it was saved: a dict of texts.";
inline constexpr const char* kLightKind =
    "\"fixed\": it is lit as it was in the images; \"directional\" or \"point\": `render` takes a light.";
inline constexpr const char* kLights =
    "The lights of the images, places or directions (`light_kind`): float64 of (n, 3); none where no light is asked "
    "for.";
inline constexpr const char* kCameras = "From where the images were taken: a list of `Camera`.";
inline constexpr const char* kCamera = "A camera of the images: its place, its lens. `Model.render` draws through it.";
inline constexpr const char* kWidth = "Of its images, pixels.";
inline constexpr const char* kHeight = "Of its images, pixels.";
inline constexpr const char* kIntrinsics =
    "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels: float64 of (3, 3); integer coordinates are the middles of "
    "pixels.";
inline constexpr const char* kCameraFromObject =
    "From the frame of the mesh to the camera's, x right, y down, z forward (OpenCV): float64 of (4, 4).";
inline constexpr const char* kLens =
    "What `distortion` is of: \"opencv\" (k1 k2 p1 p2 k3) or \"fisheye\" (k1 k2 k3 k4).";
inline constexpr const char* kDistortion = "float64 of (5,); all zero is a pinhole.";
inline constexpr const char* kBounds = "Least and greatest coordinates of the surface: float64 of (2, 3).";

inline constexpr const char* kError = "What Sheen cannot do, and why.";
inline constexpr const char* kFileError = "A file or folder is missing, broken, or cannot be written.";
inline constexpr const char* kConfigError = "An argument is out of range, or contradicts another one.";

}  // namespace sheen::words
