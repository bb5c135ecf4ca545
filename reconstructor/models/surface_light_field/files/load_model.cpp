// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <nlohmann/json.hpp>
#include <set>

#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/light_field_file/json_parts.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/models/surface_light_field/files/model_layout.h"

namespace sheen {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::uint64_t kOnlySnapshot = 1;  ///< number of a model that does not change

/// model.json, read field by field.
class Description {
 public:
  explicit Description(const fs::path& folder) : file_((folder / kJsonFile).string()) {
    if (!fs::exists(folder)) throw FileError(folder.string(), "no such folder");
    try {
      json_ = Json::parse(read_file(file_));
    } catch (const Json::exception& error) {
      throw FileError(file_, std::string("is not valid JSON: ") + error.what());
    }
    if (!json_.is_object() || text("format") != kModelFormat)
      throw FileError(file_, "describes no surface light field");
    const auto version = number<std::int64_t>(json_, "version");
    if (version > kModelVersion)
      throw FileError(file_, "is of version " + std::to_string(version) + ", but this program reads version " +
                                 std::to_string(kModelVersion) + "; use a newer Sheen");
    if (version < 1) fail("version", "must be at least 1");
    if (version < kModelVersion)
      throw FileError(file_, "is of version " + std::to_string(version) + ", but this program reads version " +
                                 std::to_string(kModelVersion) + "; build the model again from its images");
  }

  [[noreturn]] void fail(const std::string& field, const std::string& what) const {
    throw FileError(file_, field + ": " + what);
  }
  std::string text(const char* field) const {
    const auto found = json_.find(field);
    if (found == json_.end() || !found->is_string()) fail(field, "must be a text");
    return found->get<std::string>();
  }
  /// A list of so many numbers within low..high.
  template <typename T>
  std::vector<T> list(const Json& object, const char* field, std::size_t size, double low, double high) const {
    const auto found = object.find(field);
    if (found == object.end() || !found->is_array()) fail(field, "must be a list");
    if (found->size() != size)
      fail(field, "has " + std::to_string(found->size()) + " entries instead of " + std::to_string(size));
    std::vector<T> out;
    for (const Json& value : *found) {
      const bool fits = std::is_integral_v<T> ? value.is_number_integer() : value.is_number();
      if (!fits || !(value.get<double>() >= low && value.get<double>() <= high))
        fail(field, "entry " + std::to_string(out.size()) + " is not a valid number here");
      out.push_back(value.get<T>());
    }
    return out;
  }
  const Json& json() const { return json_; }
  const Json& object(const char* field) const {
    const auto found = json_.find(field);
    if (found == json_.end() || !found->is_object()) fail(field, "must be an object");
    return *found;
  }
  /// Length of a list of an object.
  std::size_t count(const char* object_field, const char* field) const {
    const Json& holder = object(object_field);
    const auto found = holder.find(field);
    if (found == holder.end() || !found->is_array()) fail(std::string(object_field) + "." + field, "must be a list");
    return found->size();
  }
  ModelMetadata metadata() const {
    ModelMetadata metadata;
    const auto found = json_.find("metadata");
    if (found == json_.end()) return metadata;
    if (!found->is_object()) fail("metadata", "must be an object");
    for (const auto& [key, value] : found->items()) {
      if (!value.is_string()) fail("metadata." + key, "must be a text");
      metadata[key] = value.get<std::string>();
    }
    return metadata;
  }

 private:
  template <typename T>
  T number(const Json& object, const char* field) const {
    const auto found = object.find(field);
    if (found == object.end() || !found->is_number_integer()) fail(field, "must be a whole number");
    return found->get<T>();
  }

  std::string file_;
  Json json_;
};

std::shared_ptr<const Mesh> read_mesh(const Description& description, const fs::path& folder) {
  const fs::path file = folder / kMeshFile;
  if (content_hash(read_file(file)) != description.text("mesh_hash"))
    throw FileError(file.string(), "is not the mesh that model.json was written for (a save cut short, or an edit?)");
  return std::make_shared<Mesh>(load_mesh_unchanged(file));
}

std::shared_ptr<const MapLayout> read_maps(const Description& description, const Mesh& mesh) {
  const auto read = [&](const char* field) {
    auto resolution = description.list<std::uint8_t>(description.json(), field, mesh.triangles.size(), 2, 255);
    constexpr std::int64_t kMostSamples = std::int64_t{1} << 28;  // values of a patch's samples are counted in 32 bits
    std::int64_t samples = 0;
    for (const std::uint8_t side : resolution) samples += 3 * std::int64_t{lattice_samples(side)};
    if (samples > kMostSamples)
      description.fail(field, "asks for " + std::to_string(samples) + " samples, more than " +
                                  std::to_string(kMostSamples) + " that a model may have");
    return resolution;
  };
  const bool filtered_for_others = description.json().contains("filter_resolution");
  return std::make_shared<MapLayout>(read("lattice_resolution"),
                                     filtered_for_others ? read("filter_resolution") : std::vector<std::uint8_t>());
}

/// A field that `from_json` reads.
template <typename Value>
Value read_part(const Description& description, const char* field, Value (*from_json)(const Json&)) {
  const auto found = description.json().find(field);
  try {
    return from_json(found == description.json().end() ? Json() : *found);
  } catch (const std::invalid_argument& error) {
    description.fail(field, error.what());
  }
}

std::shared_ptr<const PatchShapes> read_shapes(const Description& description, const Mesh& mesh,
                                               const MapLayout& maps) {
  const std::size_t triangles = mesh.triangles.size();
  auto patch_of = description.list<std::uint32_t>(description.json(), "patch_of_triangle", triangles, 0,
                                                  static_cast<double>(triangles) - 1);
  std::vector<bool> there(triangles);
  std::uint32_t last = 0;
  for (const std::uint32_t patch : patch_of) {
    there[patch] = true;
    last = std::max(last, patch);
  }
  for (std::uint32_t patch = 0; patch < last; ++patch)
    if (!there[patch]) description.fail("patch_of_triangle", "patch " + std::to_string(patch) + " has no triangle");
  return std::make_shared<const PatchShapes>(patch_shapes(mesh, maps, std::move(patch_of)));
}

/// Patches with all but what maps.exr holds, and where that stands.
struct Patches {
  ModelLayout layout;
  std::vector<std::shared_ptr<PatchSnapshot>> data;  ///< in the order of the layout
  std::vector<std::shared_ptr<VertexViews>> views;   ///< of all their vertices one after the other, as in the layout
  std::shared_ptr<const ReflectionDrift> reflection;

  VertexInterpolant& vertex(std::size_t i) {
    return data[layout.vertices[i].entry]->vertices[layout.vertices[i].vertex];
  }
};

Patches read_patch_list(const Description& description, const PatchShapes& shapes) {
  constexpr int kMaxViews = 60000, kMaxCount = 1 << 30;
  const Json& list = description.object("patches");
  const std::size_t count = description.count("patches", "patch");
  const auto patch =
      description.list<std::uint32_t>(list, "patch", count, 0, static_cast<double>(shapes.patches.size()) - 1);
  const auto rank = description.list<int>(list, "rank", count, 0, kMaxRank);
  std::size_t vertices = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0 && patch[i] <= patch[i - 1]) description.fail("patches.patch", "must rise from entry to entry");
    if (static_cast<std::uint32_t>(rank[i]) > 3 * shapes.patches[patch[i]].samples)
      description.fail("patches.rank", "entry " + std::to_string(i) + " exceeds the patch's rows");
    vertices += shapes.patches[patch[i]].vertices.size();
  }
  const Json& json = description.object("vertices");
  const auto views = description.list<int>(json, "views", vertices, 0, kMaxViews);
  const auto folded = description.list<int>(json, "views_folded", vertices, 0, kMaxCount);
  const auto scale = description.list<float>(json, "kernel_scale_rad", vertices, 1e-6, 1e6);
  const auto nugget = description.list<float>(json, "kernel_nugget", vertices, 0, 1e6);
  const auto shape = description.list<int>(json, "kernel_shape", vertices, 0, 1);
  const auto sill = description.list<float>(json, "sill", vertices, 0, 1e6);
  const auto residual = description.list<float>(json, "residual", vertices, 0, 1e6);
  const auto cosine = description.list<float>(json, "best_cosine", vertices, -2, 2);
  Patches patches;
  std::size_t next = 0;
  for (std::size_t i = 0; i < count; ++i) {
    patches.layout.add_patch(patch[i], static_cast<int>(shapes.patches[patch[i]].samples), rank[i]);
    auto data = std::make_shared<PatchSnapshot>();
    data->vertices.resize(shapes.patches[patch[i]].vertices.size());
    for (VertexInterpolant& vertex : data->vertices) {
      patches.layout.add_vertex(views[next]);
      auto& from = patches.views.emplace_back(std::make_shared<VertexViews>());
      from->kernel = {scale[next], nugget[next], static_cast<KernelShape>(shape[next])};
      from->best_cosine = cosine[next];
      vertex.views = from;
      vertex.sill = sill[next];
      vertex.residual = residual[next];
      vertex.views_folded = folded[next];
      ++next;
    }
    patches.data.push_back(std::move(data));
  }
  return patches;
}

/// Takes the parts of maps.exr into the patches.
class MapsReader {
 public:
  MapsReader(fs::path file, Patches& patches) : file_(std::move(file)), patches_(patches) {
    const ModelLayout& layout = patches.layout;
    for (int r = 0; r < layout.max_rank; ++r)
      expect(rank_part("surface", r), {"R", "G", "B"}, layout.samples,
             [this, r](const ImageF& image) { take_surface(image, r); });
    expect("measured", {"Y"}, layout.samples, [this](const ImageF& image) { take_measured(image); });
    expect("views", views_channels(layout.max_rank), layout.views, [this](const ImageF& image) { take_views(image); });
    expect("vertices", vertices_channels(layout.max_rank), layout.vertices.size(),
           [this](const ImageF& image) { take_vertices(image); });
  }

  void read(const std::string& id) {
    std::set<std::string> there;
    const ExrAttributes attributes = read_exr(
        file_,
        [&](const std::string& name) {
          there.insert(name);
          return false;
        },
        nullptr);
    for (const auto& [name, part] : expected_)
      if (!there.contains(name)) fail(name, "is missing");
    const auto found = attributes.find(kModelIdAttribute);
    if (found == attributes.end() || found->second != id)
      throw FileError(file_.string(), "does not belong to model.json (a save cut short?)");
    // Memory for the maps only now that a part stands behind each rank, and only as much as the file can hold.
    constexpr double kSlack = 64e6, kDensest = 2000;  // as for a single part (exr.cpp)
    double claimed = 0;
    for (const PatchEntry& entry : patches_.layout.patches) claimed += 3.0 * entry.samples * entry.rank * sizeof(float);
    if (claimed > kSlack + kDensest * double(fs::file_size(file_)))
      throw FileError(file_.string(), "is too small for the " + std::to_string(std::int64_t(claimed / 1e6)) +
                                          " MB of surface maps that model.json describes");
    basis_.resize(patches_.data.size());
    for (std::size_t i = 0; i < patches_.data.size(); ++i) {
      const PatchEntry& entry = patches_.layout.patches[i];
      basis_[i].resize(3 * entry.samples, entry.rank);
    }
    read_exr(
        file_, [&](const std::string& name) { return expected_.contains(name); }, [&](ExrPart&& part) { take(part); });
    for (std::size_t i = 0; i < patches_.data.size(); ++i) patches_.data[i]->basis = std::exchange(basis_[i], {});
  }

 private:
  struct Expected {
    std::vector<std::string> channels;
    std::size_t pixels;
    std::function<void(const ImageF&)> take;
  };

  [[noreturn]] void fail(const std::string& part, const std::string& what) const {
    throw FileError(file_.string(), "part \"" + part + "\" " + what);
  }
  void expect(const std::string& name, std::vector<std::string> channels, std::size_t pixels,
              std::function<void(const ImageF&)> take) {
    expected_[name] = {std::move(channels), pixels, std::move(take)};
  }
  void take(const ExrPart& part) {
    const Expected& expected = expected_.at(part.name);
    if (part.channels != expected.channels) fail(part.name, "has other channels than its ranks ask for");
    const AtlasSize size = atlas_size(expected.pixels);
    if (part.image.width() != size.width || part.image.height() != size.height)
      fail(part.name, "has " + std::to_string(part.image.width()) + " x " + std::to_string(part.image.height()) +
                          " pixels instead of " + std::to_string(size.width) + " x " + std::to_string(size.height));
    if (!Eigen::Map<const Eigen::ArrayXf>(part.image.data(), Eigen::Index(part.image.size())).allFinite())
      fail(part.name, "holds a value that is not finite");
    expected.take(part.image);
  }

  void take_surface(const ImageF& image, int rank) {
    for (std::size_t i = 0; i < patches_.data.size(); ++i) {
      const PatchEntry& entry = patches_.layout.patches[i];
      if (rank < entry.rank)
        basis_[i].col(rank) =
            Eigen::Map<const Eigen::VectorXf>(image.data() + 3 * entry.first_sample, 3 * entry.samples);
    }
  }
  void take_measured(const ImageF& image) {
    for (std::size_t i = 0; i < patches_.data.size(); ++i) {
      const PatchEntry& entry = patches_.layout.patches[i];
      patches_.data[i]->shown.resize(static_cast<std::size_t>(entry.samples));
      for (int s = 0; s < entry.samples; ++s) {
        const float fraction = image.data()[entry.first_sample + static_cast<std::size_t>(s)];
        if (!(fraction >= 0 && fraction <= 1)) fail("measured", "holds a fraction outside 0..1");
        patches_.data[i]->shown[static_cast<std::size_t>(s)] = static_cast<std::uint8_t>(std::lround(255 * fraction));
      }
    }
  }
  std::string name_of(const VertexEntry& entry) const {
    return "patch " + std::to_string(patches_.layout.patches[entry.entry].patch) + ", vertex " +
           std::to_string(entry.vertex);
  }
  void take_views(const ImageF& image) {
    const int channels = image.channels();
    for (std::size_t i = 0; i < patches_.layout.vertices.size(); ++i) {
      const VertexEntry& entry = patches_.layout.vertices[i];
      VertexViews& views = *patches_.views[i];
      const Eigen::Map<const Eigen::MatrixXf> pixels(image.data() + channels * entry.first_view, channels, entry.views);
      views.directions = pixels.topRows<3>();
      views.reliability = pixels.row(3).transpose();
      if (!(views.reliability.array() > 0).all()) fail("views", name_of(entry) + ": a reliability is not above 0");
      patches_.vertex(i).weights =
          PackedColumns<float>::fixed_point(pixels.middleRows(kViewChannels, entry.rank).transpose());
      for (int k = 0; k < entry.views; ++k)
        if (std::abs(views.directions.col(k).norm() - 1) > 1e-3f)
          fail("views", name_of(entry) + ": a direction is not a unit vector");
    }
  }
  void take_vertices(const ImageF& image) {
    for (std::size_t i = 0; i < patches_.layout.vertices.size(); ++i) {
      const VertexEntry& entry = patches_.layout.vertices[i];
      VertexInterpolant& vertex = patches_.vertex(i);
      VertexViews& views = *patches_.views[i];
      const float* pixel = image.data() + std::size_t(image.channels()) * i;
      views.frame = Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(pixel);
      if ((views.frame * views.frame.transpose() - Eigen::Matrix3f::Identity()).cwiseAbs().maxCoeff() > 1e-3f)
        fail("vertices", name_of(entry) + ": the frame is not orthonormal");
      vertex.mean = Eigen::Map<const Eigen::VectorXf>(pixel + 9, entry.rank);
      const Eigen::Map<const Eigen::VectorXf> drift(pixel + 9 + patches_.layout.max_rank, entry.rank);
      if (!patches_.reflection || drift.isZero(0)) continue;
      vertex.drift = drift;
      views.reflection = patches_.reflection;
    }
  }

  fs::path file_;
  Patches& patches_;
  std::map<std::string, Expected> expected_;
  std::vector<Eigen::MatrixXf> basis_;  ///< per patch, while it is read
};

bool alike(const VertexViews& a, const VertexViews& b) {
  return a.directions.cols() == b.directions.cols() && a.directions == b.directions && a.reliability == b.reliability &&
         a.kernel == b.kernel && a.reflection == b.reflection && a.frame == b.frame && a.best_cosine == b.best_cosine;
}

/// Whether views are interpolated as the paper does it.
bool is_triangulated(const Description& description) {
  const std::string word = description.text("interpolation");
  if (word != kKrigingWord && word != kDelaunayWord)
    description.fail("interpolation", std::string("must be ") + kKrigingWord + " or " + kDelaunayWord);
  return word == kDelaunayWord;
}

/// What the window paints red; files that do not say have the expected error.
GuidanceMethod guidance_of(const Description& description) {
  if (!description.json().contains("guidance")) return GuidanceMethod::kExpectedError;
  if (description.text("guidance") != kPaperHeuristicWord)
    description.fail("guidance", std::string("must be ") + kPaperHeuristicWord + " or not there");
  return GuidanceMethod::kPaperHeuristic;
}

/// Patches round a vertex that have the same views share them again.
void share_views(Patches& patches, const PatchShapes& shapes) {
  std::vector<std::vector<std::shared_ptr<const VertexViews>>> round(shapes.first_round.size() - 1);
  for (std::size_t i = 0; i < patches.layout.vertices.size(); ++i) {
    const VertexEntry& entry = patches.layout.vertices[i];
    const std::uint32_t patch = patches.layout.patches[entry.entry].patch;
    auto& there = round[shapes.patches[patch].vertices[entry.vertex]];
    const auto same =
        std::find_if(there.begin(), there.end(), [&](const auto& views) { return alike(*views, *patches.views[i]); });
    if (same != there.end()) {
      patches.vertex(i).views = *same;
    } else {
      patches.views[i]->believe_reflection();
      there.push_back(patches.views[i]);
    }
  }
}

}  // namespace

std::shared_ptr<const SurfaceLightFieldSnapshot> load_model(const fs::path& folder, const ShowModel& show) {
  const Description description(folder);
  const auto mesh = read_mesh(description, folder);
  const std::vector<PosedCamera> cameras = read_part(description, "cameras", cameras_from_json);
  if (show) show(bare_mesh(mesh, cameras));
  const auto maps = read_maps(description, *mesh);
  const auto shapes = read_shapes(description, *mesh, *maps);
  Patches patches = read_patch_list(description, *shapes);
  patches.reflection = read_part(description, "reflection", reflection_from_json);
  MapsReader(folder / kMapsFile, patches).read(description.text("id"));
  share_views(patches, *shapes);
  if (is_triangulated(description))
    for (std::size_t i = 0; i < patches.layout.vertices.size(); ++i) patches.vertex(i).triangulate();

  SurfaceLightFieldSnapshot::Patches all(shapes->patches.size());
  for (std::size_t i = 0; i < patches.data.size(); ++i) all[patches.layout.patches[i].patch] = patches.data[i];
  return std::make_shared<SurfaceLightFieldSnapshot>(mesh, maps, shapes, std::move(all), kOnlySnapshot,
                                                     read_part(description, "exposure", exposure_from_json), cameras,
                                                     guidance_of(description));
}

ModelMetadata load_model_metadata(const fs::path& folder) {
  return Description(folder).metadata();
}

}  // namespace sheen
