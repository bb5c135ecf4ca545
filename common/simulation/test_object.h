// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "common/geometry/mesh.h"
#include "common/simulation/reflectance.h"

namespace sheen {

/// A generated object: its mesh is closed and wound outward, its look is a function of the place in space.
struct TestObject {
  std::string name;
  Mesh mesh;                             ///< metres; stands on z = 0, round the z axis
  std::vector<Eigen::Vector3f> normals;  ///< unit, per vertex, of the smooth surface behind the mesh
  std::function<Material(const Eigen::Vector3f&)> material;
};

/// The demo's object, a hard case: a ribbed teapot 200 mm across and 119 mm tall, about 12K triangles, its glaze
/// textured down to a millimetre and glossy with a gloss that varies; spout, handle, knob and foot hide one another.
TestObject make_demo_object();

/// The same teapot of bronze: hardly any light but what it reflects like a dull mirror (`simulate --object bronze`).
TestObject make_bronze_object();

/// The same teapot in polished lacquer: narrow, bright highlights that move with the eye (`simulate --object lacquer`).
TestObject make_lacquer_object();

/// The demo's object as a closed mesh of about this many triangles (500 or more); finer detail is rounded off, and
/// sheets that are closer than a triangle may touch.
Mesh make_demo_mesh(int triangles);

/// Sphere of one material; `subdivisions` of an icosahedron.
TestObject make_sphere(const Material& material, double radius_m, const Eigen::Vector3d& centre, int subdivisions);

/// The textured glossy sphere of `simulate --object sphere`, 90 mm across.
TestObject make_demo_sphere();

/// "demo", "bronze", "lacquer" or "sphere". Throws ConfigError for any other name.
TestObject make_test_object(const std::string& name);

}  // namespace sheen
