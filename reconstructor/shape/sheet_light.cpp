// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/sheet_light.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/base/order_statistics.h"

namespace sheen {
namespace {

constexpr int kFewestPixels = 40;   // of a tag, for it to be recognised
constexpr double kTagAgrees = 0.8;  // correlation of a tag with its picture
constexpr float kNot = std::numeric_limits<float>::quiet_NaN();

/// Of the pixels of a tag: ink, level (mean of the channels) and colour, and where they are.
struct TagSums {
  double n = 0, i = 0, ii = 0, l = 0, ll = 0, il = 0;
  Eigen::Array3d c = Eigen::Array3d::Zero(), ic = Eigen::Array3d::Zero();
  Eigen::Vector2d place = Eigen::Vector2d::Zero(), places = Eigen::Vector2d::Zero();
};

}  // namespace

SheetPrediction predict(const StagePicture& sheet, const PosedCamera& camera) {
  const Camera& c = camera.camera;
  const Rigid3 object_from_camera = camera.camera_from_object.inverse();
  const Eigen::Vector3d eye = object_from_camera.translation;
  const auto on_plane = [&](double x, double y) -> Eigen::Vector2d {
    const Eigen::Vector3d ray = object_from_camera.rotation * Eigen::Vector3d((x - c.cx) / c.fx, (y - c.cy) / c.fy, 1);
    if (!(ray.z() < 0) || !(eye.z() > 0)) return Eigen::Vector2d::Constant(kNot);
    return eye.head<2>() - eye.z() / ray.z() * ray.head<2>();
  };
  SheetPrediction predicted{.point = {},
                            .ink = ImageF(c.width, c.height, 1, kNot),
                            .least_ink = ImageF(c.width, c.height, 1, kNot),
                            .most_ink = ImageF(c.width, c.height, 1, kNot),
                            .tag = {}};
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x) {
      Eigen::AlignedBox2d part;
      const Eigen::Vector2d point = on_plane(x, y);
      bool known = sheet.known().contains(point);
      for (const double dx : {-0.5, 0.5})
        for (const double dy : {-0.5, 0.5}) {
          const Eigen::Vector2d corner = on_plane(x + dx, y + dy);
          known = known && sheet.known().contains(corner);
          part.extend(corner);
        }
      predicted.point.push_back(point.cast<float>());
      predicted.tag.push_back(known ? sheet.tag_at(point) : -1);
      if (known) predicted.ink.at(x, y) = sheet.ink(part);
    }
  for (int y = 1; y + 1 < c.height; ++y)
    for (int x = 1; x + 1 < c.width; ++x) {
      float least = 1, most = 0;
      bool known = true;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const float ink = predicted.ink.at(x + dx, y + dy);
          known = known && !std::isnan(ink);
          least = std::min(least, ink);
          most = std::max(most, ink);
        }
      if (known) predicted.least_ink.at(x, y) = least, predicted.most_ink.at(x, y) = most;
    }
  return predicted;
}

SheetLight fit_light(const StagePicture& sheet, const SheetPrediction& predicted, const ImageF& colour) {
  std::vector<TagSums> sums(sheet.tags());
  for (std::size_t p = 0; p < predicted.tag.size(); ++p) {
    const float ink = predicted.ink.data()[p];
    const Eigen::Array3d rgb = Eigen::Map<const Eigen::Array3f>(colour.data() + 3 * p).cast<double>();
    if (predicted.tag[p] < 0 || std::isnan(ink) || !rgb.allFinite()) continue;
    TagSums& s = sums[predicted.tag[p]];
    const double level = rgb.mean();
    s.n += 1, s.i += ink, s.ii += ink * ink, s.l += level, s.ll += level * level, s.il += ink * level;
    s.c += rgb, s.ic += ink * rgb;
    s.place += predicted.point[p].cast<double>();
    s.places += predicted.point[p].cast<double>().cwiseAbs2();
  }
  SheetLight light{.tags = {}, .seen = std::vector<bool>(sums.size(), false), .ink = {}, .tag_size = 0};
  std::array<std::vector<double>, 3> inks;
  for (std::size_t number = 0; number < sums.size(); ++number) {
    const TagSums& s = sums[number];
    if (s.n < kFewestPixels) continue;
    const double ii = s.ii - s.i * s.i / s.n, ll = s.ll - s.l * s.l / s.n, il = s.il - s.i * s.l / s.n;
    if (!(ii > 0) || !(il < 0) || !(il * il >= kTagAgrees * kTagAgrees * ii * ll)) continue;
    const Eigen::Array3d slope = (s.ic - s.i / s.n * s.c) / ii, paper = s.c / s.n - slope * s.i / s.n;
    if (!(paper > 0).all()) continue;
    light.tags.push_back({static_cast<int>(number), (s.place / s.n).cast<float>(), paper.cast<float>()});
    light.seen[number] = true;
    const Eigen::Vector2d spread = s.places / s.n - (s.place / s.n).cwiseAbs2();
    light.tag_size = std::max(light.tag_size, static_cast<float>(std::sqrt(12 * spread.maxCoeff())));
    for (int channel = 0; channel < 3; ++channel)
      inks[channel].push_back(std::max(0.0, 1 + slope[channel] / paper[channel]));
  }
  for (int channel = 0; channel < 3 && !light.tags.empty(); ++channel)
    light.ink[channel] = static_cast<float>(median(inks[channel]));
  return light;
}

}  // namespace sheen
