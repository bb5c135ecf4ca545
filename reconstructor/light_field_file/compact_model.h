// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh.h"
#include "reconstructor/light_field_file/mesh_coding.h"
#include "reconstructor/light_field_file/patch_shapes.h"
#include "reconstructor/numerics/packed_columns.h"
#include "reconstructor/numerics/reflection_drift.h"
#include "reconstructor/numerics/view_kernel.h"
#include "reconstructor/radiance/exposure_field.h"
#include "reconstructor/surface/map_layout.h"
#include "reconstructor/surface/nearest_seen.h"
#include "reconstructor/surface/sample_state.h"

namespace sheen {

/// A view that a vertex has: the image that it stands for. Views that were merged stand a little beside it.
struct CompactView {
  std::uint16_t image = 0;    ///< index into CompactModel::cameras
  Eigen::Vector3f direction;  ///< unit, from the vertex; of the camera itself unless `moved`
  bool moved = false;
  float reliability = 1;
};

/// From where a vertex was seen and how patches are interpolated there.
struct CompactVertex {
  bool seen = false;               ///< by any image; one that is not takes the views of its `source`
  std::vector<CompactView> views;  ///< by ascending image
  std::uint8_t kernel = 0;         ///< index into CompactModel::kernels
  bool drift = false;              ///< takes part in the reflection that all vertices share
  float sill = 0, residual = 0;
  int views_folded = 0;
};

/// Colours of a patch, sRGB-encoded in grey levels (0..255): row i in image j is mean_i + basis_i . coefficients_j.
struct Patch {
  Eigen::VectorXf mean;            ///< 3 * samples; empty where nothing is known at its vertices
  PackedColumns<float> basis;      ///< rows x terms, by falling energy
  Eigen::MatrixXf coefficients;    ///< terms x images (`patch_images`)
  Eigen::VectorXf displayed;       ///< per term: RMS of what it adds to the picture
  std::vector<SampleState> state;  ///< per sample
};

/// A surface light field with one basis for a few triangles: colour(s, d) = mean(s) + basis(s) sum_c beta_c A w_c(d),
/// where A are the patch's coefficients in the images and w_c(d) the kriging weights of the views that corner c has.
/// A triangle is stored once, and blended between its corners.
struct CompactModel {
  static constexpr float kMostBrightest = 30000;  ///< the largest radiance of a half float, in grey levels

  std::shared_ptr<const Mesh> mesh;
  std::shared_ptr<const GridMesh> grid;  ///< the mesh in whole numbers
  std::shared_ptr<const MapLayout> maps;
  std::vector<PosedCamera> cameras;   ///< of the images
  std::vector<GridMesh::Point> eyes;  ///< where the cameras stand (`grid_eyes`)
  ExposureField exposure;
  std::shared_ptr<const ReflectionDrift> reflection;  ///< null where no vertex uses it
  std::vector<ViewKernel> kernels;
  std::vector<CompactVertex> vertices;  ///< of the mesh
  std::vector<std::uint32_t> source;    ///< per vertex: itself, or the seen one that is its guess (`nearest_seen`)
  std::size_t patch_triangles = 1;      ///< that `shapes` were cut by
  PatchShapes shapes;
  std::vector<Patch> patches;  ///< as `shapes` has them
  float brightest = 0;         ///< of the colours that images showed, in grey levels: none is drawn brighter
  int layers = 0;              ///< of the file
  int missing_layers = 0;      ///< of them: the file was cut short
  double missing_square = 0;   ///< what these would add to pictures: mean square per value, in grey levels

  /// The vertex whose views a vertex is drawn with; null where nothing is known.
  const CompactVertex* drawn_by(std::size_t vertex) const {
    return source[vertex] == kNoVertex ? nullptr : &vertices[source[vertex]];
  }
};

/// The brightest colour that the model's pictures have, sRGB-encoded with white at 1: interpolation goes a little
/// beyond what images showed.
float brightest_drawn(const CompactModel& model);

/// Maps of terms in fixed point: from the first on behind which 8 bits are off by less than 0.02 grey levels (RMS) in
/// the picture, with 8 bits. `grey_levels`: in the picture, of a value of 1, per column.
PackedColumns<float> packed_terms(const Eigen::MatrixXf& columns, const Eigen::VectorXf& grey_levels);

/// From a vertex to a camera.
Eigen::Vector3f camera_direction(const CompactModel& model, std::size_t vertex, std::size_t camera);

/// Where each vertex takes its views from (`CompactModel::source`), once it is known which vertices were seen.
void find_sources(CompactModel& model);

/// Images that any vertex of the patch has a view of, ascending.
std::vector<std::uint16_t> patch_images(const CompactModel& model, const PatchShape& shape);

/// For each view of a vertex, where its image stands among those of a patch.
std::vector<Eigen::Index> places(const CompactVertex& vertex, const std::vector<std::uint16_t>& images);

/// Directions and reliabilities of a vertex's views, and its drift in them (empty without).
struct KrigingSystem {
  Eigen::Matrix3Xf directions;
  Eigen::VectorXf reliability, drift;
  ViewKernel kernel;
};
/// `normal`: of the vertex whose views these are.
KrigingSystem kriging_system(const CompactModel& model, const CompactVertex& vertex, const Eigen::Vector3f& normal);

}  // namespace sheen
