// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/lumigraph_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "common/base/format.h"
#include "common/image/color.h"
#include "common/image/image_metrics.h"
#include "common/parallel/for_each.h"
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_painter.h"
#include "reconstructor/models/intrinsic_lumigraph/predicted_arrival.h"
#include "reconstructor/models/intrinsic_lumigraph/seen_surface.h"
#include "reconstructor/studies/shadow_warp.h"

namespace sheen {
namespace {

constexpr int kRedError = 150;     // sum of the three channels' errors that a map shows as red
constexpr int kVisibleError = 30;  // of the same sum
constexpr int kGridStep = 40;      // pixels
constexpr int kMagnified = 3;

/// The view's colours as the lumigraph knows them, under other shadows.
ImageU8 lit_under(const StillLife& scene, const LightState& light, const ImageU8& shadow) {
  const LumigraphData& data = *scene.model->data();
  RelitView relit = relight(central_view(scene), data.lights, scene.model->light_place(light), in_parallel);
  scale(relit, light.rgb);
  return to_srgb8(shadowed(relit, inverse(shadow)));
}

/// Lines that make a movement visible.
ImageU8 with_grid(ImageU8 mask) {
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x)
      if (x % kGridStep == 0 || y % kGridStep == 0) mask.at(x, y) = static_cast<std::uint8_t>(64 + mask.at(x, y) / 2);
  return mask;
}

/// White where the truth alone is in shadow, black where the other alone is, grey where they agree (001 figure 10).
ImageU8 difference(const ImageU8& shadow, const ImageU8& truth) {
  ImageU8 shown(truth.width(), truth.height(), 1, 128);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const bool is = shadow.data()[i] >= 128, should = truth.data()[i] >= 128;
    if (is != should) shown.data()[i] = should ? 255 : 0;
  }
  return shown;
}

/// Sum of the three channels' absolute errors, per pixel.
std::vector<int> summed_error(const ImageU8& picture, const ImageU8& truth) {
  std::vector<int> error(truth.size() / 3);
  for (std::size_t i = 0; i < truth.size(); ++i)
    error[i / 3] += std::abs(int(picture.data()[i]) - int(truth.data()[i]));
  return error;
}

/// From blue (none) to red.
ImageU8 error_colours(const ImageU8& picture, const ImageU8& truth) {
  const std::vector<int> error = summed_error(picture, truth);
  cv::Mat levels(truth.height(), truth.width(), CV_8UC1), colours;
  for (std::size_t i = 0; i < error.size(); ++i)
    levels.data[i] = static_cast<std::uint8_t>(std::min(255, 255 * error[i] / kRedError));
  cv::applyColorMap(levels, colours, cv::COLORMAP_JET);
  cv::cvtColor(colours, colours, cv::COLOR_BGR2RGB);
  ImageU8 shown(truth.width(), truth.height(), 3);
  std::copy_n(colours.data, shown.size(), shown.data());
  return shown;
}

/// The middle of a picture, magnified.
ImageU8 closeup(const ImageU8& picture) {
  const int w = picture.width() / kMagnified, h = picture.height() / kMagnified;
  ImageU8 shown(kMagnified * w, kMagnified * h, 3);
  for (int y = 0; y < shown.height(); ++y)
    for (int x = 0; x < shown.width(); ++x)
      std::copy_n(
          picture.pixel((picture.width() - w) / 2 + x / kMagnified, (picture.height() - h) / 2 + y / kMagnified), 3,
          shown.pixel(x, y));
  return shown;
}

/// The scene in a light halfway, by all that are compared.
struct Halfway {
  ImageU8 truth, lumigraph, warped, linear;  ///< sRGB
  double lumigraph_db = 0, warped_db = 0, linear_db = 0;
  double lumigraph_iou = 0, warped_iou = 0, linear_iou = 0;
};
Halfway halfway(const StillLife& scene, LumigraphPainter& painter, std::size_t first_light) {
  const ShadowRow row = shadows_between(scene, first_light);
  const std::size_t middle = row.places.size() / 2;
  const PosedCamera from = scene.rig.central_camera();
  const LightState light = scene.rig.light_at(row.places[middle]);
  Halfway out{.truth = to_srgb8(scene.rig.picture(from, light).radiance),
              .lumigraph = to_srgb8(painter.paint(from, light)),
              .warped = lit_under(scene, light, row.warped[middle]),
              .linear = to_srgb8(interpolated_truth(scene.rig, from, row.places[middle]).radiance)};
  out.lumigraph_db = squared_error(out.lumigraph, out.truth, {}).psnr_db();
  out.warped_db = squared_error(out.warped, out.truth, {}).psnr_db();
  out.linear_db = squared_error(out.linear, out.truth, {}).psnr_db();
  out.lumigraph_iou = iou(row.lumigraph[middle], row.truth[middle]);
  out.warped_iou = iou(row.warped[middle], row.truth[middle]);
  out.linear_iou = iou(row.linear[middle], row.truth[middle]);
  return out;
}

std::string two(double value) {
  return format("%.2f", value);
}
std::string three(double value) {
  return format("%.3f", value);
}

std::string size_of(const LightRig& rig) {
  return format("%zu lights, %dx%d views of %dx%d", rig.lights().size(), rig.options().columns, rig.options().rows,
                rig.options().width, rig.options().height);
}

}  // namespace

Figure figure_moved_masks(const ShadowRow& row) {
  const std::size_t last = row.places.size() - 1, middle = last / 2;
  const double ours = iou(row.warped[middle], row.truth[middle]), linear = iou(row.linear[middle], row.truth[middle]);
  Figure figure{.number = 7,
                .title = "shadows of images, moved as those of the depth map move",
                .paper = "masks between two lights follow from the masks in both and from the geometry",
                .ours = format("IoU with the true shadows halfway: %.2f, by linear interpolation %.2f", ours, linear),
                .holds = ours > linear};
  Figure::Table table{
      "lumigraph_moved_masks", "IoU with the true shadows", {"shadows", "first light", "halfway", "second light"}, {}};
  const auto add = [&](const char* name, const std::vector<ImageU8>& masks) {
    std::vector<std::string> cells{name};
    for (const std::size_t k : {std::size_t{0}, middle, last}) cells.push_back(three(iou(masks[k], row.truth[k])));
    table.rows.push_back(std::move(cells));
  };
  add("of the depth map", row.geometric);
  add("of the images, moved by affine maps (the paper)", row.warped);
  add("of the lumigraph", row.lumigraph);
  add("linear interpolation of exact ones", row.linear);
  figure.tables.push_back(std::move(table));
  std::vector<std::vector<ImageU8>> rows;
  for (const auto* masks : {&row.geometric, &row.warped, &row.lumigraph, &row.truth})
    rows.push_back({(*masks)[0], (*masks)[middle], (*masks)[last]});
  figure.pictures.push_back({"lumigraph_moved_masks",
                             "first light, halfway, second light; rows: shadows of the depth map, of the images moved "
                             "by affine maps, of the lumigraph, the truth",
                             mosaic(rows)});
  return figure;
}

Figure figure_depth_shadows(const StillLife& scene) {
  const PosedCamera from = scene.rig.central_camera();
  const IntrinsicView& view = central_view(scene);
  const LightSet& lights = scene.model->data()->lights;
  const Occluders surface(depth_surface(from, view.depth));
  const SeenSurface seen(surface, from);
  Figure::Table table{"lumigraph_depth_shadows",
                      "IoU with the true shadows in the captured lights",
                      {"light", "of the depth map", "of the hull in space", "of the images"},
                      {}};
  Overlap depth_map, images;
  std::vector<std::vector<ImageU8>> rows(3);
  for (std::size_t l = 0; l < scene.rig.lights().size(); ++l) {
    const SimulatedPicture truth = scene.rig.picture(from, scene.rig.lights()[l]);
    const Lamp lamp = lights.lamp(scene.model->light_place(scene.rig.lights()[l]));
    const ImageU8 geometric = inverse(seen.reached(lamp)),
                  by_hull = inverse(reached_past(scene.model->data()->hull, view, lamp)),
                  mask = inverse(view.arrives[l]);
    for (std::size_t i = 0; i < mask.size(); ++i) {
      depth_map.add(geometric.data()[i] >= 128, truth.shadow.data()[i] != 0);
      images.add(mask.data()[i] >= 128, truth.shadow.data()[i] != 0);
    }
    table.rows.push_back({format("%zu", l + 1), three(iou(geometric, truth.shadow)), three(iou(by_hull, truth.shadow)),
                          three(iou(mask, truth.shadow))});
    if (l % 3 != 0) continue;
    rows[0].push_back(to_srgb8(truth.radiance));
    rows[1].push_back(lit_under(scene, scene.rig.lights()[l], geometric));
    rows[2].push_back(lit_under(scene, scene.rig.lights()[l], by_hull));
  }
  Figure figure{.number = 8,
                .title = "shadows that a depth map casts",
                .paper = "what lies behind the surface is missing, so they may be incorrect",
                .ours = format("IoU over all lights %.2f, of the images' masks %.2f", depth_map.iou(), images.iou()),
                .holds = depth_map.iou() < images.iou()};
  figure.tables.push_back(std::move(table));
  figure.pictures.push_back({"lumigraph_depth_shadows",
                             "captured lights; rows: the scene, the same in the shadows of its depth map, and in those "
                             "of the hull in space",
                             mosaic(rows)});
  return figure;
}

Figure figure_shadow_shapes(const ShadowRow& row) {
  Figure figure{.number = 9,
                .title = "shapes of shadows in lights between",
                .paper = "they can be computed at any sampling rate, and are reasonably correct"};
  Plot plot{.title = "Shadows between two captured lights",
            .x = {.label = "part of the way from one captured light to the next"},
            .y = {.label = "IoU with the true shadows"}};
  Figure::Table table{"lumigraph_shadow_shapes",
                      "IoU with the true shadows",
                      {"part of the way", "lumigraph", "affine maps (the paper)", "depth map", "linear interpolation"},
                      {}};
  const std::array<std::pair<const char*, const std::vector<ImageU8>*>, 4> ways{
      {{"lumigraph", &row.lumigraph},
       {"affine maps (the paper)", &row.warped},
       {"depth map", &row.geometric},
       {"linear interpolation", &row.linear}}};
  for (const auto& way : ways) plot.series.push_back({.name = way.first, .x = {}, .y = {}});
  double least = 1, least_linear = 1;
  for (std::size_t k = 0; k < row.places.size(); ++k) {
    const double part = row.places[k] - row.places[0];
    std::vector<std::string> cells{three(part)};
    for (std::size_t w = 0; w < ways.size(); ++w) {
      const double value = iou((*ways[w].second)[k], row.truth[k]);
      plot.series[w].add(part, value);
      cells.push_back(three(value));
    }
    least = std::min(least, plot.series[0].y[k]);
    least_linear = std::min(least_linear, plot.series[3].y[k]);
    table.rows.push_back(std::move(cells));
  }
  figure.ours =
      format("IoU of at least %.2f anywhere between, linear interpolation at least %.2f", least, least_linear);
  figure.holds = least > least_linear;
  figure.plots.push_back({"lumigraph_shadow_shapes", std::move(plot)});
  figure.tables.push_back(std::move(table));
  std::vector<std::vector<ImageU8>> rows;
  for (const auto* masks : {&row.geometric, &row.truth, &row.lumigraph, &row.warped}) {
    std::vector<ImageU8>& line = rows.emplace_back();
    for (std::size_t k = 0; k < masks->size(); k += 2) line.push_back(with_grid((*masks)[k]));
  }
  figure.pictures.push_back(
      {"lumigraph_shadow_shapes",
       "five lights from one captured one to the next; rows: shadows of the depth map, the truth, "
       "of the lumigraph, of affine maps",
       mosaic(rows)});
  return figure;
}

Figure figure_shadow_difference(const ShadowRow& row) {
  const std::size_t middle = row.places.size() / 2;
  const ImageU8& truth = row.truth[middle];
  Figure::Table table{"lumigraph_shadow_difference",
                      "Shadows halfway between two captured lights, pixels in parts of those that are in shadow",
                      {"by", "missing, %", "too many, %", "IoU"},
                      {}};
  std::vector<double> wrong;
  const auto add = [&](const char* name, const ImageU8& shadow) {
    double missing = 0, excess = 0, all = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const bool is = shadow.data()[i] >= 128, should = truth.data()[i] >= 128;
      all += should;
      missing += should && !is;
      excess += is && !should;
    }
    wrong.push_back((missing + excess) / all);
    table.rows.push_back(
        {name, format("%.1f", 100 * missing / all), format("%.1f", 100 * excess / all), three(iou(shadow, truth))});
  };
  add("lumigraph", row.lumigraph[middle]);
  add("affine maps (the paper)", row.warped[middle]);
  add("depth map", row.geometric[middle]);
  add("linear interpolation", row.linear[middle]);
  Figure figure{.number = 10,
                .title = "difference of shadows",
                .paper = "the computed shapes are reasonably correct",
                .ours = format("%.0f %% of the shadows' pixels are wrong, %.0f %% by affine maps, %.0f %% by linear "
                               "interpolation",
                               100 * wrong[0], 100 * wrong[1], 100 * wrong[3]),
                .holds = wrong[0] < wrong[3]};
  figure.tables.push_back(std::move(table));
  figure.pictures.push_back(
      {"lumigraph_shadow_difference",
       "the truth, the lumigraph, their difference; below, affine maps, linear interpolation "
       "and the difference of affine maps; white is missing, black too much",
       mosaic({{truth, row.lumigraph[middle], difference(row.lumigraph[middle], truth)},
               {row.warped[middle], row.linear[middle], difference(row.warped[middle], truth)}})});
  return figure;
}

Figure figure_light_between(const StillLife& scene, int number) {
  const std::string file = format("lumigraph_%s", number == 11 ? "toys" : "glossy_toys");
  Figure figure{.number = number,
                .title = "pictures in lights between, " + size_of(scene.rig),
                .paper = "linear interpolation gives soft shadows that jump; these move and stay sharp"};
  Figure::Table table{file,
                      "Halfway between captured lights, " + size_of(scene.rig),
                      {"between lights", "lumigraph, dB", "affine maps (the paper), dB", "linear interpolation, dB",
                       "shadow IoU, lumigraph", "affine maps", "linear interpolation"},
                      {}};
  LumigraphPainter painter(scene.model);
  std::vector<std::vector<ImageU8>> rows(4);
  Halfway sum, middle;
  const std::size_t count = scene.rig.lights().size() - 1;
  for (std::size_t l = 0; l < count; ++l) {
    Halfway at = halfway(scene, painter, l);
    table.rows.push_back({format("%zu and %zu", l + 1, l + 2), two(at.lumigraph_db), two(at.warped_db),
                          two(at.linear_db), three(at.lumigraph_iou), three(at.warped_iou), three(at.linear_iou)});
    const auto add = [&](double Halfway::*part) { sum.*part += at.*part / static_cast<double>(count); };
    for (const auto part : {&Halfway::lumigraph_db, &Halfway::warped_db, &Halfway::linear_db, &Halfway::lumigraph_iou,
                            &Halfway::warped_iou, &Halfway::linear_iou})
      add(part);
    if (l % 2 == 1 && rows[0].size() < 3) {
      rows[0].push_back(at.truth);
      rows[1].push_back(at.lumigraph);
      rows[2].push_back(at.warped);
      rows[3].push_back(at.linear);
    }
    if (l == count / 2) middle = std::move(at);
  }
  table.rows.push_back({"mean", two(sum.lumigraph_db), two(sum.warped_db), two(sum.linear_db), three(sum.lumigraph_iou),
                        three(sum.warped_iou), three(sum.linear_iou)});
  figure.ours =
      format("%.2f dB in the mean, affine maps %.2f, linear interpolation %.2f; shadow IoU %.2f, %.2f, %.2f",
             sum.lumigraph_db, sum.warped_db, sum.linear_db, sum.lumigraph_iou, sum.warped_iou, sum.linear_iou);
  figure.holds = sum.lumigraph_db > sum.linear_db && sum.lumigraph_iou > sum.linear_iou;
  figure.tables.push_back(std::move(table));
  figure.pictures.push_back(
      {file, "lights between; rows: the truth, the lumigraph, affine maps, linear interpolation", mosaic(rows)});
  figure.pictures.push_back(
      {file + "_closeup", "the middle of one (figure 13): the truth, the lumigraph, affine maps, linear interpolation",
       mosaic({{closeup(middle.truth), closeup(middle.lumigraph)}, {closeup(middle.warped), closeup(middle.linear)}})});
  return figure;
}

Figure figure_error_maps(const StillLife& scene) {
  LumigraphPainter painter(scene.model);
  const Halfway at = halfway(scene, painter, scene.rig.lights().size() / 2 - 1);
  Figure::Table table{"lumigraph_errors",
                      "Errors halfway between two captured lights, the three channels' grey levels added",
                      {"by", "mean", "pixels with more than 30, %", "largest", "PSNR, dB"},
                      {}};
  std::vector<double> means;
  const auto add = [&](const char* name, const ImageU8& picture, double psnr_db) {
    const std::vector<int> error = summed_error(picture, at.truth);
    double sum = 0, visible = 0;
    for (const int value : error) sum += value, visible += value > kVisibleError;
    const auto pixels = static_cast<double>(error.size());
    means.push_back(sum / pixels);
    table.rows.push_back({name, two(sum / pixels), two(100 * visible / pixels),
                          format("%d", *std::max_element(error.begin(), error.end())), two(psnr_db)});
  };
  add("lumigraph", at.lumigraph, at.lumigraph_db);
  add("affine maps (the paper)", at.warped, at.warped_db);
  add("linear interpolation", at.linear, at.linear_db);
  Figure figure{.number = 14,
                .title = "error maps, " + size_of(scene.rig),
                .paper = "less error than by linear interpolation",
                .ours = format("%.2f grey levels in the mean, affine maps %.2f, linear interpolation %.2f", means[0],
                               means[1], means[2]),
                .holds = means[0] < means[2]};
  figure.tables.push_back(std::move(table));
  figure.pictures.push_back(
      {"lumigraph_errors",
       "the lumigraph, the truth, linear interpolation, affine maps; below, their errors, from blue (none) to red (150 "
       "levels and more, the channels added)",
       mosaic({{at.lumigraph, at.truth, at.linear, at.warped},
               {error_colours(at.lumigraph, at.truth), error_colours(at.truth, at.truth),
                error_colours(at.linear, at.truth), error_colours(at.warped, at.truth)}})});
  return figure;
}

}  // namespace sheen
