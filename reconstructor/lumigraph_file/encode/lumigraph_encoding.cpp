// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/lumigraph_file/encode/lumigraph_encoding.h"

#include <nlohmann/json.hpp>

#include "reconstructor/coding/camera_json.h"
#include "reconstructor/lumigraph_file/lumigraph_format.h"

namespace sheen {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson describe(const LumigraphData& data) {
  std::vector<PosedCamera> cameras;
  OrderedJson lights = OrderedJson::array(), units = OrderedJson::array();
  for (const auto& view : data.views) {
    cameras.push_back(view->from);
    lights.push_back(view->lights);
    units.push_back(view->residual_unit);
  }
  const Eigen::Matrix3Xd& places = data.lights.places;
  return {{"light_kind", static_cast<int>(data.lights.kind)},
          {"lights", std::vector<double>(places.data(), places.data() + places.size())},
          {"error", data.error},
          {"of_images", data.of_images},
          {"hull",
           {{"origin", {data.hull.origin().x(), data.hull.origin().y(), data.hull.origin().z()}},
            {"cell", data.hull.cell()},
            {"size", {data.hull.size().x(), data.hull.size().y(), data.hull.size().z()}}}},
          {"cameras", cameras_to_json(cameras)},
          {"view_lights", lights},
          {"residual_units", units}};
}

template <typename T>
void append_plane(std::string& out, const Image<T>& image) {
  // By the bytes of equal worth, one after the other: they are like their neighbours.
  const auto* bytes = reinterpret_cast<const char*>(image.data());
  for (std::size_t b = 0; b < sizeof(T); ++b)
    for (std::size_t i = 0; i < image.size(); ++i) out.push_back(bytes[i * sizeof(T) + b]);
}

std::string bytes_of(const ShadowHull& hull) {
  return {hull.cells().begin(), hull.cells().end()};
}

std::string planes_of(const IntrinsicView& view) {
  std::string out;
  append_plane(out, view.depth);
  append_plane(out, view.reflectance);
  append_plane(out, view.slope);
  append_plane(out, view.ambient);
  return out;
}

std::string planes_of_light(const IntrinsicView& view, std::size_t light) {
  std::string out;
  append_plane(out, view.arrives[light]);
  append_plane(out, view.residual[light]);
  return out;
}

}  // namespace

std::string encode_lumigraph(const LumigraphData& data, const StepsDone& progress) {
  std::string out = start_of_file(kLumigraphFileFormat, {});
  append_chunk(out, "DESC", packed(describe(data).dump()));
  append_chunk(out, "HULL", packed(bytes_of(data.hull), kQuickPacking));
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const IntrinsicView& view = *data.views[v];
    append_chunk(out, "VIEW", packed(planes_of(view), kQuickPacking));
    for (std::size_t i = 0; i < view.lights.size(); ++i)
      append_chunk(out, "LAMP", packed(planes_of_light(view, i), kQuickPacking));
    if (progress) progress(v + 1, data.views.size());
  }
  return out;
}

}  // namespace sheen
