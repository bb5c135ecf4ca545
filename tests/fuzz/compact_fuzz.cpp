// SPDX-License-Identifier: Apache-2.0
// Whatever a small model's file holds, its checksums right or wrong: a model that can be looked at, or a FileError.
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "common/base/crc32c.h"
#include "common/base/errors.h"
#include "reconstructor/light_field_file/encode/light_field_encoding.h"
#include "reconstructor/light_field_file/light_field_file.h"
#include "reconstructor/models/surface_light_field/compact/compact_light_field.h"
#include "reconstructor/models/surface_light_field/compact/fit_patches.h"
#include "reconstructor/surface/view_hemisphere.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace sheen;
using fuzz::Input;

/// A tetrahedron that three cameras have seen; its last triangle is a guess.
SurfaceLightFieldSnapshot small_model() {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0.1f, 0, 0}, {0, 0.1f, 0}, {0, 0, 0.1f}, {-0.1f, -0.1f, -0.1f}};
  mesh->triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
  auto maps = std::make_shared<MapLayout>(std::vector<std::uint8_t>{5, 3, 4, 2});
  constexpr int kViews = 3;
  const Camera camera{.width = 640, .height = 480, .fx = 800, .fy = 800, .cx = 320, .cy = 240};
  std::vector<PosedCamera> cameras;
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(1, 0.2, 0.3), {0.2, 1, 0.4}, {0.3, 0.3, 1}})
    cameras.push_back({camera, look_at(eye, {0, 0, 0}, {0, 0.1, 1})});
  auto reflection = std::make_shared<ReflectionDrift>();
  reflection->coefficients.setConstant(0.1f);
  const auto shapes = std::make_shared<const PatchShapes>(patch_shapes(*mesh, *maps, {0, 1, 2, 3}));
  SurfaceLightFieldSnapshot::Patches data(4);
  for (std::size_t p = 0; p < 3; ++p) {
    const std::uint32_t samples = shapes->patches[p].samples;
    auto patch = std::make_shared<PatchSnapshot>();
    patch->basis =
        Eigen::MatrixXf(Eigen::MatrixXf::NullaryExpr(3 * Eigen::Index{samples}, 2, [](Eigen::Index i, Eigen::Index j) {
          return 0.3f + 0.2f * std::sin(static_cast<float>(3 * i + 7 * j));
        }));
    patch->shown.assign(samples, 200);
    for (const std::uint32_t v : shapes->patches[p].vertices) {
      VertexInterpolant& at = patch->vertices.emplace_back();
      auto from = std::make_shared<VertexViews>();
      at.weights = Eigen::MatrixXf(Eigen::MatrixXf::NullaryExpr(kViews, 2, [](Eigen::Index j, Eigen::Index i) {
        return 0.3f * static_cast<float>(i + 1) * (j == 1 ? -2.0f : 1.0f);
      }));
      at.mean = Eigen::VectorXf::Constant(2, 0.5f);
      from->frame = hemisphere_frame(mesh->vertices[v].normalized());
      from->directions.resize(3, kViews);
      for (int k = 0; k < kViews; ++k)
        from->directions.col(k) =
            (camera_centre(cameras[static_cast<std::size_t>(k)].camera_from_object).cast<float>() - mesh->vertices[v])
                .normalized();
      from->reliability = Eigen::VectorXf::Constant(kViews, 0.5f);
      if (v == 2) {
        at.drift = Eigen::VectorXf::Constant(2, 0.1f);
        from->reflection = reflection;
      }
      from->kernel = kViewKernels[v];
      at.sill = 0.01f;
      at.views_folded = kViews;
      at.views = std::move(from);
    }
    data[p] = std::move(patch);
  }
  return {mesh, maps, shapes, std::move(data), 1, {}, cameras};
}

std::string valid_file() {
  const SurfaceLightFieldSnapshot model = small_model();
  const CanonicalMesh mesh = canonical_mesh(model.mesh());
  CompactModel patches = fit_patches(model, mesh, 0.1, 2);
  return encode_light_field(patches, mesh, 2, {}, one_after_the_other);
}

constexpr std::size_t kStart = 12, kHead = 16;

struct Chunk {
  std::string name, bytes;
};

std::vector<Chunk> chunks_of(const std::string& file) {
  std::vector<Chunk> chunks;
  for (std::size_t at = kStart; at < file.size();) {
    std::uint64_t size = 0;
    std::memcpy(&size, file.data() + at + 8, sizeof size);
    chunks.push_back({file.substr(at, 4), file.substr(at + kHead, size)});
    at += kHead + size;
  }
  return chunks;
}

/// With checksums that are right.
std::string joined(const std::string& start, const std::vector<Chunk>& chunks) {
  std::string file = start;
  for (const Chunk& chunk : chunks) {
    const std::uint32_t sum = crc32c({reinterpret_cast<const std::uint8_t*>(chunk.bytes.data()), chunk.bytes.size()});
    const std::uint64_t size = chunk.bytes.size();
    file += chunk.name;
    file.append(reinterpret_cast<const char*>(&sum), sizeof sum);
    file.append(reinterpret_cast<const char*>(&size), sizeof size);
    file += chunk.bytes;
  }
  return file;
}

void look_at_all(const CompactLightField& model) {
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(1, 0.3, 0.2), Eigen::Vector3d(-0.2, -0.4, -0.9)}) {
    const auto shader = model.shader_for({eye});
    for (std::uint32_t t = 0; t < std::min<std::size_t>(model.mesh().triangles.size(), 8); ++t)
      for (const auto& [u, v] : {std::pair(0.2f, 0.3f), std::pair(1.0f, 0.0f), std::pair(0.0f, 1.0f)})
        shader->shade(t, u, v);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string kValid = valid_file();
  Input in{{data, size}};
  const bool right_checksums = in.byte() % 8 != 0;
  std::vector<Chunk> chunks = chunks_of(kValid);
  std::string file = kValid;
  if (right_checksums) {
    while (in.rest.size() >= 5) {
      Chunk& chunk = chunks[in.byte() % chunks.size()];
      fuzz::damage_once(chunk.bytes, in);
    }
    file = joined(kValid.substr(0, kStart), chunks);
  } else {
    while (in.rest.size() >= 4) fuzz::damage_once(file, in);
  }
  try {
    CompactModel model = decode_light_field(file, "fuzzed", one_after_the_other);
    look_at_all(*std::make_shared<CompactLightField>(std::move(model), nullptr));
  } catch (const FileError&) {
  }
  return 0;
}
