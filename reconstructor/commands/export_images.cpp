// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "common/datasets/colmap_writer.h"
#include "common/datasets/file_finder.h"
#include "common/image/color.h"
#include "common/image/image_io.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/exports.h"
#include "reconstructor/commands/plain_names.h"
#include "reconstructor/exchange/surface_points.h"
#include "reconstructor/radiance/capture_rules.h"
#include "reconstructor/radiance/radiance_image.h"
#include "reconstructor/radiance/undistortion.h"
#include "reconstructor/scene/model_choice.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

/// What a format makes of an image's name, which stands in `images`.
struct Layout {
  std::string named_in;       ///< before the name in the description
  bool mask_keeps_extension;  ///< COLMAP looks for masks/a.jpg.png, beside images/a.jpg
};
constexpr const char* kPoints = "sparse_pc.ply";  // as nerfstudio calls it

/// Whether other programs read an image as it is.
bool is_common(const fs::path& image) {
  const std::string extension = loose_name(image.extension().string());
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

void copy_bytes(const fs::path& from, const fs::path& to) {
  write_file(to, read_file(from));
}

/// Writes images and masks of captures into a folder, one after the other, and keeps what is to be said of them.
class ImageFolder {
 public:
  ImageFolder(fs::path folder, Layout layout, bool undistort, int hold_out_every)
      : folder_(std::move(folder)), layout_(std::move(layout)), undistort_(undistort), every_(hold_out_every) {}

  /// `stored`: its file, empty where it has none. `points` may be null.
  void add(const Capture& capture, const fs::path& stored, SurfacePoints* points) {
    const bool as_it_is = !undistort_ && is_common(stored);
    const std::string extension = as_it_is ? loose_name(stored.extension().string()) : ".png";
    const std::string name = names_.take(capture.name) + extension;
    const fs::path image = folder_ / "images" / name;
    const double exposure = exposure_product(capture);
    if (views_.empty()) first_exposure_ = exposure;
    const float gain = exposure > 0 && first_exposure_ > 0 ? static_cast<float>(exposure / first_exposure_) : 1;
    const bool is_read = !as_it_is || points;
    UndistortedPicture picture{.camera = capture.camera,
                               .linear = is_read ? level_radiance(capture, gain) : ImageF(),
                               .mask = usable_pixels(capture)};
    if (undistort_ && !capture.camera.is_pinhole()) picture = undistorted(picture.camera, picture.linear, picture.mask);
    const ImageU8 shown = to_srgb8(picture.linear);
    make_folder(image.parent_path());
    if (as_it_is)
      copy_bytes(stored, image);
    else
      write_png(image, shown);
    DatasetView& view = views_.emplace_back(DatasetView{.name = layout_.named_in + name,
                                                        .image_path = image,
                                                        .mask_path = {},
                                                        .camera = picture.camera,
                                                        .camera_from_object = capture.pose.camera_from_object,
                                                        .light = capture.light,
                                                        .purpose = capture.purpose,
                                                        .exposure_s = {}});
    if (is_held_out(capture, every_)) view.purpose = Purpose::kHeldOut;
    view.exposure_locked = capture.exposure.locked || exposure > 0;
    if (!picture.mask.empty()) write_mask(view, picture.mask);
    if (points) points->look(shown, picture.mask, {view.camera, view.camera_from_object});
  }

  /// All of them. Some programs take masks for all images or for none.
  const std::vector<DatasetView>& finish() {
    const auto masked = [](const DatasetView& view) { return view.mask_path.has_value(); };
    if (std::any_of(views_.begin(), views_.end(), masked))
      for (DatasetView& view : views_)
        if (!masked(view)) write_mask(view, ImageU8(view.camera.width, view.camera.height, 1, 255));
    return views_;
  }

 private:
  void write_mask(DatasetView& view, const ImageU8& mask) const {
    fs::path name = fs::relative(view.image_path, folder_ / "images");
    if (!layout_.mask_keeps_extension) name.replace_extension();
    view.mask_path = folder_ / "masks" / (name.string() + ".png");
    make_folder(view.mask_path->parent_path());
    write_png(*view.mask_path, mask);
  }

  fs::path folder_;
  Layout layout_;
  bool undistort_;
  int every_;
  double first_exposure_ = 0;
  PlainNames names_;
  std::vector<DatasetView> views_;
};

bool is_saved_model(const std::string& path) {
  try {
    kind_of_model(path);
    return true;
  } catch (const FileError&) {
    return false;
  }
}

/// What `build` holds out where the captures do not say: of a model for what moves between them.
int hold_out_every(const RigMotion& motion) {
  return SceneRequest({}, "auto").chosen_by(motion).settings->hold_out_every;
}

/// Empty where there is none.
std::optional<Mesh> mesh_of(const std::string& source, const std::string& mesh) {
  if (!mesh.empty()) return load_mesh(mesh).mesh;
  const fs::path model = fs::path(source) / kSessionModel;
  std::error_code ignored;
  if (!fs::exists(model, ignored)) return std::nullopt;
  return open_model(model).snapshot->mesh();
}

nlohmann::json export_set(const CaptureSet& captures, int every, const std::optional<Mesh>& mesh, const fs::path& path,
                          bool colmap, bool undistort) {
  NewFolder out(path);
  ImageFolder folder(out.unfinished(),
                     colmap ? Layout{.named_in = "", .mask_keeps_extension = true}
                            : Layout{.named_in = "images/", .mask_keeps_extension = false},
                     undistort, every);
  std::optional<SurfacePoints> points;
  if (mesh) points.emplace(*mesh);
  bool lit = false;
  {
    Progress progress("exporting", captures.size);
    for (std::size_t i = 0; i < captures.size; ++i) {
      if (stop_requested()) throw Error("stopped before it was exported");
      const Capture capture = captures.read(i);
      if (capture.pose.usable()) {
        folder.add(capture, captures.image_files.empty() ? fs::path() : captures.image_files[i],
                   points ? &*points : nullptr);
        lit = lit || capture.light.kind != LightKind::kFixed;
      }
      progress.update(i + 1);
    }
  }
  const std::vector<DatasetView>& views = folder.finish();
  const std::vector<ColouredPoint> cloud = points ? points->points() : std::vector<ColouredPoint>();
  if (views.empty()) throw FileError(path.string(), "cannot be written: no image has a pose");
  if (colmap) {
    const fs::path model = out.unfinished() / "sparse" / "0";
    make_folder(model);
    write_colmap(model, views, cloud);
  } else {
    if (!cloud.empty()) write_point_cloud(out.unfinished() / kPoints, cloud);
    write_transforms(out.unfinished() / "transforms.json", views, cloud.empty() ? "" : kPoints);
  }
  out.finish();

  const auto held_out = std::count_if(views.begin(), views.end(),
                                      [](const DatasetView& view) { return view.purpose == Purpose::kHeldOut; });
  std::printf("%s written: %zu images, %td of them held out, %zu points\n", path.c_str(), views.size(), held_out,
              cloud.size());
  if (cloud.empty()) std::printf("without points, which some trainers begin with: --mesh FILE adds the mesh's\n");
  if (const std::size_t left_out = captures.size - views.size(); left_out > 0)
    std::printf("%zu images without a pose are left out\n", left_out);
  if (lit && colmap) std::printf("the light moves: a COLMAP model has no place for it, --transforms has\n");
  return {{"path", path.string()},
          {"images", views.size()},
          {"held_out", held_out},
          {"left_out", captures.size - views.size() + captures.damaged},
          {"withdrawn", captures.withdrawn},
          {"points", cloud.size()}};
}

}  // namespace

nlohmann::json export_images(const std::string& source, const ImageSets& sets) {
  for (const fs::path& folder : {sets.transforms, sets.colmap})
    if (!folder.empty()) check_writable_folder(folder);
  if (is_saved_model(source))
    throw ConfigError(source + ": is a model, which keeps no photographs; give the session or the data set of it");
  const CaptureSet captures = open_capture_set(source);
  if (captures.size == 0) throw FileError(source, "has no image to export");
  const int every = hold_out_every(captures.motion());
  const std::optional<Mesh> mesh = mesh_of(source, sets.mesh);
  nlohmann::json report = nlohmann::json::object();
  if (!sets.transforms.empty())
    report["transforms"] = export_set(captures, every, mesh, sets.transforms, false, sets.undistort);
  if (!sets.colmap.empty()) report["colmap"] = export_set(captures, every, mesh, sets.colmap, true, sets.undistort);
  return report;
}

}  // namespace sheen
