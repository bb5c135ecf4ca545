// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/effort/memory_need.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "common/base/errors.h"
#include "reconstructor/models/surface_light_field/ring_model.h"
#include "reconstructor/surface/vertex_ring.h"

namespace sheen {
namespace {

constexpr double kGigabyte = 1e9;
constexpr double kFixedPerTriangle = 600;  ///< mesh, ray scene, rings, and what an image shows of them
constexpr int kFewTerms = 3, kFewColumns = 8;

std::string gigabytes(double bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g GB", bytes / kGigabyte);
  return text;
}

}  // namespace

MemoryNeed memory_need(std::size_t vertices, std::size_t triangles, const SurfaceLightFieldOptions& options) {
  const double asked = options.map_scale * (options.surface_map > 0 ? options.surface_map : options.min_surface_map);
  const int side = std::max(2, static_cast<int>(std::lround(asked)));
  const auto v = static_cast<double>(vertices), t = static_cast<double>(triangles);
  const double samples = 3 * t * lattice_samples(side) / v;  // of a ring: a triangle is in three
  RingModelOptions few = options.ring;
  few.factor = few.factor.limited_to(kFewTerms, kFewTerms, kFewColumns);
  few.max_views = kFewColumns - few.factor.block;
  const double fixed = t * kFixedPerTriangle;
  return {fixed + v * RingModel::largest_bytes(samples, few),
          fixed + v * RingModel::largest_bytes(samples, options.ring)};
}

MachineMemory machine_memory() {
  MachineMemory memory;
  std::ifstream in("/proc/meminfo");
  std::string name, unit;
  for (double kilobytes = 0; in >> name >> kilobytes; std::getline(in, unit)) {
    if (name == "MemTotal:") memory.total = 1024 * kilobytes;
    if (name == "MemAvailable:") memory.available = 1024 * kilobytes;
  }
  return memory;
}

std::string memory_warning(const std::string& mesh_file, std::size_t vertices, std::size_t triangles,
                           const SurfaceLightFieldOptions& options, const MachineMemory& machine) {
  const MemoryNeed need = memory_need(vertices, triangles, options);
  if (machine.total <= 0 || need.most <= machine.available) return {};
  const double triangle_bytes = need.most / static_cast<double>(triangles);
  const double fitting = std::floor(machine.available / triangle_bytes / 1000) * 1000;
  const std::string text = std::to_string(triangles) + " triangles: the model takes " + gigabytes(need.least) + " to " +
                           gigabytes(need.most) + " of memory, this machine has " + gigabytes(machine.total) + ", " +
                           gigabytes(machine.available) + " of them free; simplify the mesh to " +
                           std::to_string(static_cast<long long>(fitting)) + " triangles";
  if (need.least > machine.total) throw FileError(mesh_file, text);
  return mesh_file + ": " + text + ", or bound the model with --memory";
}

}  // namespace sheen
