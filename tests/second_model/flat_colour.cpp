// SPDX-License-Identifier: Apache-2.0
#include "tests/second_model/flat_colour.h"

#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/radiance/capture_rules.h"
#include "tests/second_model/flat_colour_drawer.h"

namespace sheen::testing {
namespace {

using Json = nlohmann::json;

constexpr const char* kFormat = "flat colour";
const Eigen::Vector3f kGuess(0.2f, 0.2f, 0.2f);

class FlatShader : public ViewShader {
 public:
  explicit FlatShader(const FlatColourSnapshot& model) : model_(model) {}
  SurfaceSample shade(std::uint32_t triangle, float, float) const override {
    return {model_.colours()[triangle], model_.seen(triangle) ? SampleState::kMeasured : SampleState::kUnseen};
  }
  SurfaceQuality quality(std::uint32_t triangle) const override {
    return model_.seen(triangle) ? SurfaceQuality{true, 0.05f, 1, 1} : SurfaceQuality{};
  }

 private:
  const FlatColourSnapshot& model_;
};

/// It is its own constant colour, and there is nothing beside it.
class FlatPeers : public Baselines {
 public:
  explicit FlatPeers(std::shared_ptr<const ModelSnapshot> model) : model_(std::move(model)) {}
  void add(const Capture&, float, bool) override {}
  std::shared_ptr<const Appearance> constant_colour() const override { return model_; }
  std::vector<Baseline> from_photographs(std::size_t) const override { return {}; }
  BaselineHeuristic heuristic() const override {
    return {"none", [n = model_->mesh().triangles.size()](const auto&) { return std::vector<float>(n, 0.5f); }};
  }

 private:
  std::shared_ptr<const ModelSnapshot> model_;
};

class FlatColourKind : public ModelKind {
 public:
  const char* name() const override { return "flat_colour"; }
  const char* title() const override { return "flat colour"; }
  const char* file_format() const override { return kFormat; }
  std::unique_ptr<ModelSettings> default_settings() const override { return std::make_unique<FlatColourSettings>(); }
  std::shared_ptr<const ModelSnapshot> load(const std::filesystem::path& folder) const override {
    const Json json = Json::parse(read_file(folder / "model.json"));
    auto mesh = std::make_shared<Mesh>(load_mesh_unchanged(folder / "mesh.ply"));
    std::vector<Eigen::Vector3f> colours;
    std::vector<bool> seen;
    for (const Json& c : json.at("colours")) colours.emplace_back(c.at(0), c.at(1), c.at(2));
    for (const Json& s : json.at("seen")) seen.push_back(s);
    if (colours.size() != mesh->triangles.size() || seen.size() != colours.size())
      throw FileError((folder / "model.json").string(), "colours: must be one per triangle");
    return std::make_shared<FlatColourSnapshot>(std::move(mesh), std::move(colours), std::move(seen), 1);
  }
  std::unique_ptr<ModelDrawer> make_drawer(const DrawerOptions&) const override {
    return std::make_unique<FlatColourDrawer>();
  }
};

}  // namespace

std::vector<SettingKey> FlatColourSettings::keys() {
  std::vector<SettingKey> keys = image_keys();
  keys.push_back(setting("pixel_stride", pixel_stride));
  return keys;
}

void FlatColourSettings::require_valid() const {
  require_valid_images();
  if (pixel_stride < 1) throw ConfigError("flat_colour: pixel_stride must be at least 1");
}

MemoryNeed FlatColourSettings::memory_need(std::size_t, std::size_t triangles) const {
  const double bytes = static_cast<double>(triangles * sizeof(Eigen::Vector4f));
  return {bytes, 100 * bytes};
}

std::unique_ptr<AppearanceModel> FlatColourSettings::make_model(std::shared_ptr<const Mesh> mesh,
                                                                std::shared_ptr<const RayScene> /*scene*/) const {
  return std::make_unique<FlatColourModel>(std::move(mesh), *this);
}

std::unique_ptr<Baselines> FlatColourSettings::make_baselines(std::shared_ptr<const ModelSnapshot> snapshot,
                                                              bool) const {
  return std::make_unique<FlatPeers>(std::move(snapshot));
}

std::unique_ptr<ViewShader> FlatColourSnapshot::shader_for(const ViewQuery&) const {
  return std::make_unique<FlatShader>(*this);
}

bool FlatColourSnapshot::empty() const {
  return std::none_of(seen_.begin(), seen_.end(), [](bool s) { return s; });
}

SnapshotFigures FlatColourSnapshot::figures() const {
  const double seen = static_cast<double>(std::count(seen_.begin(), seen_.end(), true));
  const double fraction = seen / static_cast<double>(seen_.size());
  return {.median_rank = 1, .most_rank = 1, .seen = fraction, .measured = fraction};
}

std::shared_ptr<const ModelSnapshot> FlatColourSnapshot::filled() const {
  std::vector<Eigen::Vector3f> colours = colours_;
  for (std::size_t t = 0; t < colours.size(); ++t)
    if (!seen_[t]) colours[t] = kGuess;
  return std::make_shared<FlatColourSnapshot>(mesh_, std::move(colours), seen_, version_);
}

ViewAdvice FlatColourSnapshot::advise_next_view(const Eigen::Vector3d& eye) const {
  return {
      .eye = Eigen::Vector3d(-eye.x(), -eye.y(), eye.z()), .heuristic = 1, .angle_deg = 180, .reason = "other side"};
}

void FlatColourSnapshot::save(const std::filesystem::path& folder, const ModelMetadata& metadata,
                              const StepsDone& progress) const {
  make_folder(folder);
  Json json{{"format", kFormat}, {"metadata", metadata}, {"colours", Json::array()}, {"seen", seen_}};
  for (const Eigen::Vector3f& c : colours_) json["colours"].push_back({c.x(), c.y(), c.z()});
  save_ply(*mesh_, folder / "mesh.ply");
  write_file(folder / "model.json", json.dump());
  if (progress) progress(2, 2);
}

FlatColourModel::FlatColourModel(std::shared_ptr<const Mesh> mesh, const FlatColourSettings& settings)
    : mesh_(std::move(mesh)), settings_(settings), rays_(*mesh_) {
  settings.require_valid();
}

FlatColourModel::Image FlatColourModel::look(const Capture& capture) const {
  Image image{capture.source_session, capture.sequence,
              std::vector<Eigen::Vector4f>(mesh_->triangles.size(), Eigen::Vector4f::Zero())};
  const ImageF pixels = level_radiance(capture, 1);
  const ImageU8 usable = usable_pixels(capture);
  const std::vector<Hit> hits = rays_.cast(capture.camera, capture.pose.camera_from_object);
  const int stride = settings_.pixel_stride * (1 + effort_level_);
  for (int y = 0; y < pixels.height(); y += stride)
    for (int x = 0; x < pixels.width(); x += stride) {
      const Hit& hit = hits[static_cast<std::size_t>(y) * static_cast<std::size_t>(pixels.width()) + x];
      if (!hit || !hit.front || (!usable.empty() && !usable.at(x, y, 0))) continue;
      image.sums[hit.triangle] += Eigen::Vector4f(pixels.at(x, y, 0), pixels.at(x, y, 1), pixels.at(x, y, 2), 1);
    }
  return image;
}

IngestReport FlatColourModel::ingest(const Capture& capture) {
  IngestReport report;
  if (!capture.pose.usable()) {
    report.reason = "no_pose";
    return report;
  }
  Image image = look(capture);
  report.patches_updated = static_cast<std::size_t>(
      std::count_if(image.sums.begin(), image.sums.end(), [](const auto& sum) { return sum.w() > 0; }));
  if (report.patches_updated == 0) {
    report.reason = "object_not_in_view";
    return report;
  }
  report.status = IngestStatus::kHeldOut;
  if (is_held_out(capture, settings_.hold_out_every)) return report;
  report.status = IngestStatus::kAccepted;
  report.stage_ms["mean"] = 1;
  images_.push_back(std::move(image));
  return report;
}

bool FlatColourModel::withdraw(const Capture& capture) {
  return std::erase_if(images_, [&](const Image& image) {
           return image.source_session == capture.source_session && image.sequence == capture.sequence;
         }) > 0;
}

bool FlatColourModel::began_with(const Capture& capture) const {
  return !images_.empty() && images_.front().source_session == capture.source_session &&
         images_.front().sequence == capture.sequence;
}

void FlatColourModel::restart(int effort_level) {
  effort_level_ = effort_level;
  images_.clear();
}

std::shared_ptr<const FlatColourSnapshot> FlatColourModel::flat_snapshot(std::uint64_t version) const {
  std::vector<Eigen::Vector4f> sums(mesh_->triangles.size(), Eigen::Vector4f::Zero());
  for (const Image& image : images_)
    for (std::size_t t = 0; t < sums.size(); ++t) sums[t] += image.sums[t];
  std::vector<Eigen::Vector3f> colours;
  std::vector<bool> seen;
  for (const Eigen::Vector4f& sum : sums) {
    seen.push_back(sum.w() > 0);
    colours.push_back(sum.head<3>() / std::max(sum.w(), 1.0f));
  }
  return std::make_shared<FlatColourSnapshot>(mesh_, std::move(colours), std::move(seen), version);
}

ModelFigures FlatColourModel::figures() const {
  const std::size_t triangles = mesh_->triangles.size(), bytes = images_.size() * triangles * sizeof(Eigen::Vector4f);
  return {.images = images_.size(), .rank_histogram = {0, triangles}, .bytes = bytes, .bytes_per_patch = 16};
}

MemoryAccount FlatColourModel::memory(const CaptureSize& image) const {
  return {.ingest = image.bytes, .model = static_cast<double>(figures().bytes)};
}

const ModelKind& flat_colour_kind() {
  static const FlatColourKind kind;
  return kind;
}

}  // namespace sheen::testing
