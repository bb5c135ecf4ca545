// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/light_field_file/json_parts.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/models/surface_light_field/files/model_layout.h"

namespace sheen {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

using Snapshot = SurfaceLightFieldSnapshot;

ModelLayout layout_of(const Snapshot& model) {
  ModelLayout layout;
  for (std::size_t p = 0; p < model.patches().size(); ++p) {
    const PatchSnapshot* patch = model.patches()[p].get();
    if (!patch) continue;
    layout.add_patch(static_cast<std::uint32_t>(p), static_cast<int>(model.shapes().patches[p].samples), patch->rank());
    for (const VertexInterpolant& vertex : patch->vertices)
      layout.add_vertex(static_cast<int>(vertex.views->directions.cols()));
  }
  return layout;
}

const PatchSnapshot& patch_of(const Snapshot& model, const PatchEntry& entry) {
  return *model.patches()[entry.patch];
}

const VertexInterpolant& vertex_of(const Snapshot& model, const ModelLayout& layout, const VertexEntry& entry) {
  return patch_of(model, layout.patches[entry.entry]).vertices[entry.vertex];
}

Json conventions() {
  return {
      {"frame", "mesh frame: metres, right-handed"},
      {"values",
       "sRGB-encoded; of a sample: sum over ranks of surface map times h of the eye, the mean of h at the triangle's "
       "three corners by the barycentric coordinates; decoded once"},
      {"lattice",
       "resolution n: points (i, j), i + j < n, j fastest, at barycentric weights i/(n-1) and j/(n-1) of "
       "corners 1 and 2"},
      {"patch",
       "triangles of the same number in patch_of_triangle, in the order of the mesh, each with its lattice points; its "
       "vertices are their corners, in the order of the mesh"},
      {"measured", "fraction of the patch's images that showed the sample: 0 unseen, below 1/2 imputed, else measured"},
      {"atlas", "patches one after the other, one pixel per sample, row by row"},
      {"view",
       "h(d) = mean + drift * L(d mirrored about the third row of frame) + sum over views of weight * "
       "k(angle(d, direction)); L: reflection, orthonormal real spherical harmonics, (l, m) at l^2 + l + m; empty = 0; "
       "less and less is believed of it beyond the views: see BelievedDrift in view_kriging.h"},
      {"delaunay",
       "where interpolation is \"delaunay\", a weight is the view's own h, and h(d) is interpolated over the Delaunay "
       "triangulation of the views' first two coordinates in frame: see view_hemisphere.h"},
      {"kernel",
       "k(t) by kernel_shape: 0 = (1 + sqrt(3) t / scale) exp(-sqrt(3) t / scale), 1 = exp(-t / scale); the nugget "
       "is in the weights"}};
}

/// The function that all vertices share; null where none uses it.
const ReflectionDrift* reflection_of(const Snapshot& model) {
  for (const auto& patch : model.patches()) {
    if (!patch) continue;
    for (const VertexInterpolant& vertex : patch->vertices)
      if (vertex.views->reflection) return vertex.views->reflection.get();
  }
  return nullptr;
}

Json description_of(const Snapshot& model, const ModelLayout& layout, const std::string& mesh_hash) {
  Json json;
  json["format"] = kModelFormat;
  json["version"] = kModelVersion;
  json["mesh_hash"] = mesh_hash;
  json["conventions"] = conventions();
  json["cameras"] = cameras_to_json(model.cameras());
  json["exposure"] = exposure_to_json(model.exposure());
  json["interpolation"] = model.triangulated() ? kDelaunayWord : kKrigingWord;
  if (model.guidance_method() == GuidanceMethod::kPaperHeuristic) json["guidance"] = kPaperHeuristicWord;
  json["reflection"] = reflection_to_json(reflection_of(model));
  Json resolution = Json::array(), filter = Json::array();
  for (std::size_t t = 0; t < model.mesh().triangles.size(); ++t) {
    resolution.push_back(model.maps().resolution(t));
    filter.push_back(model.maps().filter_resolution(t));
  }
  if (filter != resolution) json["filter_resolution"] = std::move(filter);
  json["lattice_resolution"] = std::move(resolution);
  json["patch_of_triangle"] = model.shapes().patch_of;
  Json& patches = json["patches"];
  for (const char* field : {"patch", "rank"}) patches[field] = Json::array();
  for (const PatchEntry& entry : layout.patches) {
    patches["patch"].push_back(entry.patch);
    patches["rank"].push_back(entry.rank);
  }
  Json& vertices = json["vertices"];
  for (const char* field : {"views", "views_folded", "kernel_scale_rad", "kernel_nugget", "kernel_shape", "sill",
                            "residual", "best_cosine"})
    vertices[field] = Json::array();
  for (const VertexEntry& entry : layout.vertices) {
    const VertexInterpolant& vertex = vertex_of(model, layout, entry);
    vertices["views"].push_back(entry.views);
    vertices["views_folded"].push_back(vertex.views_folded);
    vertices["kernel_scale_rad"].push_back(vertex.views->kernel.scale_rad);
    vertices["kernel_nugget"].push_back(vertex.views->kernel.nugget);
    vertices["kernel_shape"].push_back(static_cast<int>(vertex.views->kernel.shape));
    vertices["sill"].push_back(vertex.sill);
    vertices["residual"].push_back(vertex.residual);
    vertices["best_cosine"].push_back(vertex.views->best_cosine);
  }
  return json;
}

/// Ties the files together: made of all that is in them but the metadata, so that the same model has the same one
/// wherever it came from.
std::string id_of(const Json& description, const Snapshot& model) {
  std::string contents = description.dump();
  const auto add = [&contents](const auto& values) {
    const auto* bytes = reinterpret_cast<const char*>(values.data());
    contents += content_hash({bytes, static_cast<std::size_t>(values.size()) * sizeof(values.data()[0])});
  };
  for (const auto& patch : model.patches()) {
    if (!patch) continue;
    add(patch->colours());
    add(patch->shown);
    for (const VertexInterpolant& vertex : patch->vertices) {
      add(vertex.views->directions);
      add(vertex.views->reliability);
      add(vertex.weights.unpacked());
      add(vertex.mean);
      add(vertex.drift);
      add(vertex.views->frame);
    }
  }
  return content_hash(contents);
}

ImageF blank_atlas(std::size_t pixels, int channels) {
  const auto [width, height] = atlas_size(pixels);
  return ImageF(width, height, channels);
}

ImageF surface_image(const Snapshot& model, const ModelLayout& layout, int rank) {
  ImageF image = blank_atlas(layout.samples, 3);
  for (const PatchEntry& entry : layout.patches)
    if (rank < entry.rank)
      Eigen::Map<Eigen::VectorXf>(image.data() + 3 * entry.first_sample, 3 * entry.samples) =
          patch_of(model, entry).colours_of_term(rank);
  return image;
}

ImageF measured_image(const Snapshot& model, const ModelLayout& layout) {
  ImageF image = blank_atlas(layout.samples, 1);
  for (const PatchEntry& entry : layout.patches) {
    const std::vector<std::uint8_t>& shown = patch_of(model, entry).shown;
    std::transform(shown.begin(), shown.end(), image.data() + entry.first_sample,
                   [](std::uint8_t fraction) { return fraction / 255.0f; });
  }
  return image;
}

ImageF views_image(const Snapshot& model, const ModelLayout& layout) {
  const int channels = kViewChannels + layout.max_rank;
  ImageF image = blank_atlas(layout.views, channels);
  for (const VertexEntry& entry : layout.vertices) {
    const VertexInterpolant& vertex = vertex_of(model, layout, entry);
    Eigen::Map<Eigen::MatrixXf> pixels(image.data() + channels * entry.first_view, channels, entry.views);
    pixels.topRows<3>() = vertex.views->directions;
    pixels.row(3) = vertex.views->reliability.transpose();
    pixels.middleRows(kViewChannels, entry.rank) = vertex.weights.unpacked().transpose();
  }
  return image;
}

ImageF vertices_image(const Snapshot& model, const ModelLayout& layout) {
  const int channels = 9 + 2 * layout.max_rank;
  ImageF image = blank_atlas(layout.vertices.size(), channels);
  for (std::size_t i = 0; i < layout.vertices.size(); ++i) {
    const VertexInterpolant& vertex = vertex_of(model, layout, layout.vertices[i]);
    float* pixel = image.data() + channels * i;
    Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>{pixel} = vertex.views->frame;
    Eigen::Map<Eigen::VectorXf>(pixel + 9, vertex.mean.size()) = vertex.mean;
    Eigen::Map<Eigen::VectorXf>(pixel + 9 + layout.max_rank, vertex.drift.size()) = vertex.drift;
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

void save_maps(const Snapshot& model, const ModelLayout& layout, const SaveOptions& options, const std::string& id,
               const fs::path& path, const StepsDone& written) {
  Parts parts;
  const AtlasSize surface = atlas_size(layout.samples);
  for (int r = 0; r < layout.max_rank; ++r)
    parts.add(rank_part("surface", r), {"R", "G", "B"}, surface, options.surface,
              [&, r] { return surface_image(model, layout, r); });
  parts.add("measured", {"Y"}, surface, ExrPrecision::kHalf, [&] { return measured_image(model, layout); });
  parts.add("views", views_channels(layout.max_rank), atlas_size(layout.views), ExrPrecision::kFloat,
            [&] { return views_image(model, layout); });
  parts.add("vertices", vertices_channels(layout.max_rank), atlas_size(layout.vertices.size()), ExrPrecision::kFloat,
            [&] { return vertices_image(model, layout); });
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

void save_model(const Snapshot& model, const fs::path& folder, const ModelMetadata& metadata,
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
