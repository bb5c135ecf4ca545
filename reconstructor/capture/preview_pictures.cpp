// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/preview_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/image/color.h"
#include "common/image/image_io.h"
#include "common/image/linear_reader.h"
#include "reconstructor/render/gl/view_controls.h"
#include "reconstructor/render/guess_marks.h"

namespace sheen {
namespace {

constexpr int kPreviewWidth = 640, kPreviewHeight = 480, kThumbnailWidth = 480;
constexpr int kJpegQuality = 80;
constexpr std::array<std::uint8_t, 3> kGround{28, 31, 34};  ///< that of the window
constexpr std::array<std::uint8_t, 3> kOutline{70, 220, 130};

std::shared_ptr<const std::string> jpeg_text(const ImageU8& image) {
  const std::vector<std::uint8_t> bytes = encode_jpeg(image, kJpegQuality);
  return std::make_shared<const std::string>(bytes.begin(), bytes.end());
}

/// The part of the camera's view that shows the object, with a rim round it.
Camera part_with(const Mesh& mesh, const Camera& camera, const Rigid3& camera_from_object) {
  constexpr double kRim = 1.1;
  const auto [centre, radius] = bounding_sphere(mesh);
  const Eigen::Vector3d at = camera_from_object.rotation * centre + camera_from_object.translation;
  const auto pixel = camera.project(at);
  const double half_height = pixel ? kRim * radius * camera.fy / at.z() : camera.height;
  if (!pixel || 2 * half_height > camera.height)
    return camera.scaled(kPreviewWidth, std::max(1, camera.height * kPreviewWidth / camera.width));
  Camera part = camera;
  part.height = static_cast<int>(std::ceil(2 * half_height));
  part.width = part.height * kPreviewWidth / kPreviewHeight;
  part.cx += 0.5 * (part.width - 1) - pixel->x();
  part.cy += 0.5 * (part.height - 1) - pixel->y();
  return part.scaled(kPreviewWidth, kPreviewHeight);
}

ImageU8 on_ground(ImageU8 picture, const ImageU8& coverage) {
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      if (coverage.at(x, y) == 0) std::ranges::copy(kGround, picture.pixel(x, y));
  return picture;
}

/// Every nth pixel: quick, and good enough for a thumbnail.
ImageU8 thumbnail(const ImageU8& image, int width) {
  const int height = std::max(1, image.height() * width / image.width());
  ImageU8 small(width, height, image.channels());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < image.channels(); ++c)
        small.at(x, y, c) = image.at(x * image.width() / width, y * image.height() / height, c);
  return small;
}

void draw_outline(ImageU8& picture, const RayPainter& painter, const Capture& capture) {
  const ImageU8 object =
      painter.silhouette(capture.camera.scaled(picture.width(), picture.height()), capture.pose.camera_from_object);
  const auto differs = [&](int x, int y) {
    return object.at(x, y) != object.at(x - 1, y) || object.at(x, y) != object.at(x, y - 1);
  };
  for (int y = 1; y < picture.height(); ++y)
    for (int x = 1; x < picture.width(); ++x)
      if (differs(x, y)) std::ranges::copy(kOutline, picture.pixel(x, y));
}

/// The mesh lit from the eye, as the window has it. `colour`: of a hit, sRGB-encoded.
template <typename Colour>
ImageU8 lit_from_eye(const Mesh& mesh, const RayPainter& painter, const Viewpoint& from, const Colour& colour) {
  const std::vector<Hit> hits = painter.cast(from.camera, from.camera_from_object);
  const Eigen::Vector3f eye = from.eye().cast<float>();
  ImageU8 picture(from.camera.width, from.camera.height, 3);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    std::uint8_t* const pixel = picture.data() + 3 * i;
    if (!hits[i]) {
      std::ranges::copy(kGround, pixel);
      continue;
    }
    const std::size_t t = hits[i].triangle;
    const float facing = std::abs(mesh.area_normal(t).normalized().dot((eye - mesh.corner(t, 0)).normalized()));
    const Eigen::Vector3f lit = 255 * (0.25f + 0.75f * facing) * colour(hits[i]);
    for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(std::min(255.0f, lit[c]));
  }
  return picture;
}

}  // namespace

std::shared_ptr<const std::string> camera_preview(const Capture& capture, const RayPainter* painter) {
  ImageU8 picture = thumbnail(to_srgb8(to_linear_rgb(capture.image)), kThumbnailWidth);
  if (painter && capture.pose.usable()) draw_outline(picture, *painter, capture);
  return jpeg_text(picture);
}

Viewpoint preview_viewpoint(const Capture* capture, const std::shared_ptr<const Mesh>& mesh) {
  if (capture) {
    const Rigid3& pose = capture->pose.camera_from_object;
    return {part_with(*mesh, capture->camera, pose), pose};
  }
  ViewControls controls;
  controls.frame(mesh);
  return controls.orbit.viewpoint(kPreviewWidth, kPreviewHeight);
}

std::shared_ptr<const std::string> model_preview(const ModelSnapshot& model, const RayPainter& painter,
                                                 const Viewpoint& from) {
  if (model.empty()) {
    const auto grey = [](const Hit&) -> Eigen::Vector3f { return Eigen::Vector3f::Constant(0.72f); };
    return jpeg_text(lit_from_eye(model.mesh(), painter, from, grey));
  }
  const PaintedView painted = painter.paint(model, from.camera, from.camera_from_object);
  return jpeg_text(on_ground(to_srgb8(painted.beauty), painted.coverage));
}

std::shared_ptr<const std::string> shape_preview(const Mesh& mesh, const RayPainter& painter, const Viewpoint& from) {
  if (mesh.evidence.empty()) return nullptr;
  return jpeg_text(lit_from_eye(mesh, painter, from, [&mesh](const Hit& hit) -> Eigen::Vector3f {
    const Triangle& t = mesh.triangles[hit.triangle];
    const auto at = [&](int c) { return evidence_color(mesh.evidence[t[c]]); };
    return (1 - hit.u - hit.v) * at(0) + hit.u * at(1) + hit.v * at(2);
  }));
}

}  // namespace sheen
