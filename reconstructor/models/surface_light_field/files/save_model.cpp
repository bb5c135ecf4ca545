// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/models/surface_light_field/files/json_parts.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/models/surface_light_field/files/model_layout.h"

namespace sheen {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

ModelLayout layout_of(const SurfaceLightFieldSnapshot& model) {
  ModelLayout layout;
  for (std::size_t v = 0; v < model.ring_data().size(); ++v)
    if (const RingSnapshot* ring = model.ring_data()[v].get())
      layout.add(static_cast<std::uint32_t>(v), model.rings().ring_samples(v), ring->rank(),
                 static_cast<int>(ring->directions.cols()));
  return layout;
}

Json conventions() {
  return {
      {"frame", "mesh frame: metres, right-handed"},
      {"values",
       "sRGB-encoded; the sum over a triangle's three rings, weighted by the barycentric coordinates, is "
       "decoded once"},
      {"lattice",
       "resolution n: points (i, j), i + j < n, j fastest, at barycentric weights i/(n-1) and j/(n-1) of "
       "corners 1 and 2"},
      {"ring", "the triangles round a vertex in the order of the mesh, each with its lattice points"},
      {"measured", "share of the ring's images that showed the sample: 0 unseen, below 1/2 imputed, else measured"},
      {"atlas", "rings one after the other, a pixel a sample, row by row"},
      {"view",
       "h(d) = mean + drift * L(d mirrored about the third row of frame) + sum over views of weight * "
       "k(angle(d, direction)); L: reflection, orthonormal real spherical harmonics, (l, m) at l^2 + l + m; empty = 0"},
      {"kernel",
       "k(t) by kernel_shape: 0 = (1 + sqrt(3) t / scale) exp(-sqrt(3) t / scale), 1 = exp(-t / scale); the nugget "
       "is in the weights"},
      {"view map",
       "a square tile per ring, row by row; pixel centres over [-1, 1]^2: the first two coordinates of "
       "frame * direction, moved to the rim where outside the unit disc"}};
}

/// The function that all rings share; null where none uses it.
const ReflectionDrift* reflection_of(const SurfaceLightFieldSnapshot& model) {
  for (const auto& ring : model.ring_data())
    if (ring && ring->reflection) return ring->reflection.get();
  return nullptr;
}

Json description_of(const SurfaceLightFieldSnapshot& model, const ModelLayout& layout, const std::string& mesh_hash) {
  Json json;
  json["format"] = kModelFormat;
  json["version"] = kModelVersion;
  json["mesh_hash"] = mesh_hash;
  json["conventions"] = conventions();
  json["cameras"] = cameras_to_json(model.cameras());
  json["exposure"] = exposure_to_json(model.exposure());
  json["reflection"] = reflection_to_json(reflection_of(model));
  Json resolution = Json::array();
  for (std::size_t t = 0; t < model.mesh().triangles.size(); ++t) resolution.push_back(model.rings().resolution(t));
  json["lattice_resolution"] = std::move(resolution);
  Json& rings = json["rings"];
  for (const char* field : {"vertex", "rank", "views", "views_folded", "kernel_scale_rad", "kernel_nugget",
                            "kernel_shape", "sill", "residual", "best_cosine"})
    rings[field] = Json::array();
  for (const RingEntry& entry : layout.rings) {
    const RingSnapshot& ring = *model.ring_data()[entry.vertex];
    rings["vertex"].push_back(entry.vertex);
    rings["rank"].push_back(entry.rank);
    rings["views"].push_back(entry.views);
    rings["views_folded"].push_back(ring.views_folded);
    rings["kernel_scale_rad"].push_back(ring.kernel.scale_rad);
    rings["kernel_nugget"].push_back(ring.kernel.nugget);
    rings["kernel_shape"].push_back(static_cast<int>(ring.kernel.shape));
    rings["sill"].push_back(ring.sill);
    rings["residual"].push_back(ring.residual);
    rings["best_cosine"].push_back(ring.best_cosine);
  }
  return json;
}

/// Ties the files together: made of all that is in them but the metadata, so that the same model has the same one
/// wherever it came from.
std::string id_of(const Json& description, const SurfaceLightFieldSnapshot& model) {
  std::string contents = description.dump();
  const auto add = [&contents](const auto& values) {
    const auto* bytes = reinterpret_cast<const char*>(values.data());
    contents += content_hash({bytes, static_cast<std::size_t>(values.size()) * sizeof(values.data()[0])});
  };
  for (const auto& ring : model.ring_data()) {
    if (!ring) continue;
    add(ring->basis);
    add(ring->directions);
    add(ring->reliability);
    add(ring->weights);
    add(ring->mean);
    add(ring->drift);
    add(ring->frame);
    add(ring->shown);
  }
  return content_hash(contents);
}

ImageF blank_atlas(std::size_t pixels, int channels) {
  const auto [width, height] = atlas_size(pixels);
  return ImageF(width, height, channels);
}

ImageF surface_image(const SurfaceLightFieldSnapshot& model, const ModelLayout& layout, int rank) {
  ImageF image = blank_atlas(layout.samples, 3);
  for (const RingEntry& entry : layout.rings)
    if (rank < entry.rank)
      Eigen::Map<Eigen::VectorXf>(image.data() + 3 * entry.first_sample, 3 * entry.samples) =
          model.ring_data()[entry.vertex]->basis.col(rank);
  return image;
}

ImageF measured_image(const SurfaceLightFieldSnapshot& model, const ModelLayout& layout) {
  ImageF image = blank_atlas(layout.samples, 1);
  for (const RingEntry& entry : layout.rings) {
    const std::vector<std::uint8_t>& shown = model.ring_data()[entry.vertex]->shown;
    std::transform(shown.begin(), shown.end(), image.data() + entry.first_sample,
                   [](std::uint8_t share) { return share / 255.0f; });
  }
  return image;
}

ImageF views_image(const SurfaceLightFieldSnapshot& model, const ModelLayout& layout) {
  const int channels = kViewChannels + layout.max_rank;
  ImageF image = blank_atlas(layout.views, channels);
  for (const RingEntry& entry : layout.rings) {
    const RingSnapshot& ring = *model.ring_data()[entry.vertex];
    Eigen::Map<Eigen::MatrixXf> pixels(image.data() + channels * entry.first_view, channels, entry.views);
    pixels.topRows<3>() = ring.directions;
    pixels.row(3) = ring.reliability.transpose();
    pixels.middleRows(kViewChannels, entry.rank) = ring.weights;
  }
  return image;
}

ImageF rings_image(const SurfaceLightFieldSnapshot& model, const ModelLayout& layout) {
  const int channels = 9 + 2 * layout.max_rank;
  ImageF image = blank_atlas(layout.rings.size(), channels);
  for (std::size_t i = 0; i < layout.rings.size(); ++i) {
    const RingSnapshot& ring = *model.ring_data()[layout.rings[i].vertex];
    float* pixel = image.data() + channels * i;
    Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>{pixel} = ring.frame;
    Eigen::Map<Eigen::VectorXf>(pixel + 9, layout.rings[i].rank) = ring.mean;
    Eigen::Map<Eigen::VectorXf>(pixel + 9 + layout.max_rank, ring.drift.size()) = ring.drift;
  }
  return image;
}

/// Direction of each pixel of a view map in the hemisphere's frame: 3 x side^2.
Eigen::Matrix3Xf view_map_directions(int side) {
  Eigen::Matrix3Xf directions(3, side * side);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      Eigen::Vector2f p(2 * (x + 0.5f) / side - 1, 2 * (y + 0.5f) / side - 1);
      if (p.squaredNorm() > 1) p.normalize();
      directions.col(y * side + x) << p, std::sqrt(std::max(0.0f, 1 - p.squaredNorm()));
    }
  return directions;
}

/// The view maps of all rings: rank x side^2 each. Portable copies, which half precision suffices for.
using ViewMap = Eigen::Matrix<Eigen::half, Eigen::Dynamic, Eigen::Dynamic>;
std::vector<ViewMap> view_maps(const SurfaceLightFieldSnapshot& model, const ModelLayout& layout, int side) {
  const Eigen::Matrix3Xf local = view_map_directions(side);
  std::vector<ViewMap> maps(layout.rings.size());
  tbb::parallel_for(std::size_t(0), maps.size(), [&](std::size_t i) {
    const RingSnapshot& ring = *model.ring_data()[layout.rings[i].vertex];
    maps[i].resize(ring.rank(), local.cols());
    if (ring.rank() == 0) return;
    for (Eigen::Index k = 0; k < local.cols(); ++k)
      maps[i].col(k) = ring.coefficients(ring.frame.transpose() * local.col(k)).cast<Eigen::half>();
  });
  return maps;
}

AtlasSize tiles_across(std::size_t rings) {
  const int across = std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(rings)))));
  return {across, std::max(1, (static_cast<int>(rings) + across - 1) / across)};
}

ImageF view_image(const std::vector<ViewMap>& maps, int side, int rank) {
  const AtlasSize tiles = tiles_across(maps.size());
  ImageF image(tiles.width * side, tiles.height * side, 1);
  for (std::size_t i = 0; i < maps.size(); ++i) {
    if (rank >= maps[i].rows()) continue;
    const int left = int(i) % tiles.width * side, top = int(i) / tiles.width * side;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) image.at(left + x, top + y) = float(maps[i](rank, y * side + x));
  }
  return image;
}

/// Parts with the functions that make their pixels when their turn comes.
struct Parts {
  std::vector<ExrPartInfo> info;
  std::vector<std::function<ImageF()>> image;

  void add(std::string name, std::vector<std::string> channels, AtlasSize size, ExrPrecision precision,
           std::function<ImageF()> make) {
    info.push_back({std::move(name), std::move(channels), size.width, size.height, precision});
    image.push_back(std::move(make));
  }
};

void save_maps(const SurfaceLightFieldSnapshot& model, const ModelLayout& layout, const SaveOptions& options,
               const std::string& id, const fs::path& path, const StepsDone& written) {
  Parts parts;
  const AtlasSize surface = atlas_size(layout.samples);
  for (int r = 0; r < layout.max_rank; ++r)
    parts.add(rank_part("surface", r), {"R", "G", "B"}, surface, options.surface,
              [&, r] { return surface_image(model, layout, r); });
  parts.add("measured", {"Y"}, surface, ExrPrecision::kHalf, [&] { return measured_image(model, layout); });
  parts.add("views", views_channels(layout.max_rank), atlas_size(layout.views), ExrPrecision::kFloat,
            [&] { return views_image(model, layout); });
  parts.add("rings", rings_channels(layout.max_rank), atlas_size(layout.rings.size()), ExrPrecision::kFloat,
            [&] { return rings_image(model, layout); });
  std::vector<ViewMap> maps;
  if (options.view_map > 0) {
    maps = view_maps(model, layout, options.view_map);
    const AtlasSize tiles = tiles_across(maps.size());
    for (int r = 0; r < layout.max_rank; ++r)
      parts.add(rank_part("view", r), {"Y"}, {tiles.width * options.view_map, tiles.height * options.view_map},
                ExrPrecision::kHalf, [&, r] { return view_image(maps, options.view_map, r); });
  }
  write_exr(path, parts.info, {{kModelIdAttribute, id}}, [&](std::size_t i) {
    written(i, parts.image.size());
    return parts.image[i]();
  });
}

/// Where the files of a model are written until all are whole; gone, with what is in it, at the end.
class Unfinished {
 public:
  explicit Unfinished(const fs::path& model) : model_(model), folder_(model / ".unfinished") {
    std::error_code error;
    new_ = fs::create_directories(model_, error);
    if (!error) fs::remove_all(folder_, error);  // of a save that was killed
    if (!error) fs::create_directory(folder_, error);
    if (error) throw FileError(model_.string(), "cannot be created: " + error.message());
  }
  ~Unfinished() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
    if (new_) fs::remove(model_, ignored);  // where nothing came to be
  }
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;

  fs::path operator/(const char* file) const { return folder_ / file; }
  void put_in_place() const {
    for (const char* file : {kMeshFile, kMapsFile, kJsonFile}) {
      std::error_code error;
      fs::rename(folder_ / file, model_ / file, error);
      if (error) throw FileError((model_ / file).string(), "cannot be written: " + error.message());
    }
  }

 private:
  fs::path model_, folder_;
  bool new_ = false;
};

}  // namespace

void save_model(const SurfaceLightFieldSnapshot& model, const fs::path& folder, const ModelMetadata& metadata,
                const SaveOptions& options) {
  constexpr std::size_t kStepsBeforeMaps = 2;  // mesh, description
  const auto report = [&options](std::size_t done, std::size_t steps) {
    if (options.progress) options.progress(done, steps);
  };
  const Unfinished unfinished(folder);
  const ModelLayout layout = layout_of(model);
  if (layout.max_rank > kMaxRank)
    throw FileError(folder.string(), "cannot be written: rank " + std::to_string(layout.max_rank) + " is above " +
                                         std::to_string(kMaxRank) + "; lower the model's max_rank");
  save_ply(model.mesh(), unfinished / kMeshFile);
  Json json = description_of(model, layout, content_hash(read_file(unfinished / kMeshFile)));
  std::string text;
  try {
    const std::string id = id_of(json, model);
    json["id"] = id;
    json["metadata"] = metadata;
    text = json.dump();
    save_maps(model, layout, options, id, unfinished / kMapsFile,
              [&](std::size_t done, std::size_t parts) { report(kStepsBeforeMaps + done, kStepsBeforeMaps + parts); });
  } catch (const Json::exception& failure) {
    throw FileError((folder / kJsonFile).string(), std::string("cannot be written: metadata: ") + failure.what());
  }
  write_file(unfinished / kJsonFile, text + "\n");
  unfinished.put_in_place();
}

}  // namespace sheen
