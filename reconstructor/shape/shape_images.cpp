// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/shape_images.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/order_statistics.h"
#include "reconstructor/shape/neighbour_views.h"
#include "reconstructor/shape/object_box.h"
#include "reconstructor/shape/stage_sightings.h"

namespace sheen {
namespace {

constexpr double kCoarseWidth_px = 320;             // of an image in which the object is looked for
constexpr double kMostWhite = 0.3, kFewWhite = 20;  // of the pixels that hide ink, and pixels: as white as paper

/// Whether the outline runs along the rim for a good part of a side.
bool cut_by_rim(const ShapeView& view) {
  constexpr double kPart = 0.03;
  if (view.outline.empty()) return false;
  const int width = view.outline.width(), height = view.outline.height();
  int at_rim = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; x += y == 0 || y + 1 == height ? 1 : std::max(1, width - 1))
      at_rim += view.outline.at(x, y) == static_cast<std::uint8_t>(Outline::kObject) ? 1 : 0;
  return at_rim > kPart * std::min(width, height);
}

/// Whether most views show the sheet, and object and paper can be told apart: what hides ink is not as white as paper.
bool sheet_tells(const std::vector<SheetSeen>& sheets) {
  double showing = 0, before_ink = 0, white = 0;
  for (const SheetSeen& sheet : sheets) {
    showing += sheet.outline.empty() ? 0 : 1;
    before_ink += static_cast<double>(sheet.before_ink);
    white += static_cast<double>(sheet.white);
  }
  return 2 * showing > static_cast<double>(sheets.size()) && white <= kFewWhite + kMostWhite * before_ink;
}

}  // namespace

ShapeImages::ShapeImages(const RefinementImages& images, const Eigen::Vector3d& place, std::size_t most,
                         const Mesh* rough_mesh)
    : all(images), used(spread_views(images.cameras, place, most)) {
  for (const std::size_t i : used) cameras.push_back(images.cameras[i]);
  if (rough_mesh) rough.emplace(*rough_mesh);
}

std::vector<ShapeView> coarse_views(ShapeImages& images) {
  std::vector<ColourView> seen;
  StageSightings sightings;
  for (std::size_t i = 0; i < images.used.size(); ++i) {
    const Capture capture = images.read(i);
    const Camera& camera = capture.camera;
    const PixelBox whole{0, 0, camera.width, camera.height};
    const double scale = std::min(1.0, kCoarseWidth_px / std::max(camera.width, camera.height));
    seen.push_back(colour_view(capture, whole, scale));
    if (images.rough) images.rough->mark_outline(seen.back().view);
    sightings.add(capture);
  }
  images.sheet = StagePicture(images.all.stage ? *images.all.stage : sightings.layout());
  std::vector<ShapeView> views;
  for (ColourView& one : seen) {
    const bool outlined = !one.view.outline.empty();
    images.backgrounds.push_back(outlined ? PlainBackground{} : plain_background(one.view));
    images.sheets.push_back(outlined || images.sheet.tags() == 0 ? SheetSeen{}
                                                                 : mark_sheet(images.sheet, one.colour, one.view));
    views.push_back(std::move(one.view));
  }
  images.before_sheet = sheet_tells(images.sheets);
  if (images.all.stage && !images.before_sheet) images.sheet = {};  // a file's word, which the images do not confirm
  for (std::size_t i = 0; i < views.size() && !images.before_sheet; ++i) {
    if (std::exchange(views[i].before_sheet, false)) views[i].outline = {};
    if (images.backgrounds[i].found) mark_background(images.backgrounds[i], views[i]);
  }
  for (const ShapeView& view : views) images.cut.push_back(cut_by_rim(view));
  return views;
}

std::vector<ShapeView> fine_views(const ShapeImages& images, const Eigen::AlignedBox3d& box, double pixels) {
  std::vector<PixelBox> parts;
  std::vector<double> areas;
  for (const PosedCamera& camera : images.cameras) {
    parts.push_back(part_with(box, camera));
    areas.push_back(double(parts.back().width()) * parts.back().height());
  }
  const double scale = std::min(1.0, std::sqrt(pixels / std::max(1.0, median(areas))));
  std::vector<ShapeView> views;
  for (std::size_t i = 0; i < images.used.size(); ++i) {
    if (parts[i].empty()) parts[i] = {0, 0, 1, 1};
    ColourView seen = colour_view(images.read(i), parts[i], scale);
    if (images.rough) images.rough->mark_outline(seen.view);
    if (seen.view.outline.empty() && images.before_sheet)
      mark_sheet(images.sheet, seen.colour, images.sheets[i], seen.view);
    else if (seen.view.outline.empty() && images.backgrounds[i].found)
      mark_background(images.backgrounds[i], seen.view);
    views.push_back(std::move(seen.view));
  }
  return views;
}

}  // namespace sheen
