// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "common/image/color.h"
#include "common/parallel/for_each.h"
#include "reconstructor/lumigraph_file/lumigraph_reader.h"
#include "tests/golden/contents.h"

namespace sheen {
namespace {

/// The bits of the numbers.
template <typename Number>
void add_image(Checksum& sum, const Image<Number>& image) {
  sum.add(image.width());
  sum.add(image.height());
  for (std::size_t i = 0; i < image.size(); ++i) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, image.data() + i, sizeof(Number));
    sum.add(bits);
  }
}

std::vector<FileContents::Part> whole_numbers(const LumigraphData& data) {
  std::vector<FileContents::Part> parts;
  for (const auto& view : data.views) {
    Checksum surface, lamps;
    add_image(surface, view->depth);
    add_image(surface, view->reflectance);
    add_image(surface, view->slope);
    add_image(surface, view->ambient);
    for (std::size_t l = 0; l < view->lights.size(); ++l) {
      lamps.add(view->lights[l]);
      add_image(lamps, view->arrives[l]);
      add_image(lamps, view->residual[l]);
    }
    parts.push_back(surface.part("surface"));
    parts.push_back(lamps.part("lamps"));
  }
  Checksum hull;
  hull.add_all(data.hull.cells());
  parts.push_back(hull.part("hull"));
  return parts;
}

std::vector<std::uint8_t> values_of(const ImageF& radiance) {
  constexpr std::size_t kApart = 17;
  std::vector<std::uint8_t> values;
  for (std::size_t i = 0; i < radiance.size(); i += kApart)
    values.push_back(value_of_255(255 * srgb_encode(radiance.data()[i])));
  return values;
}

}  // namespace

FileContents contents_of_lumigraph(std::string_view bytes, const std::string& file) {
  const LumigraphData data = read_lumigraph(bytes, file);
  FileContents contents{.whole_numbers = whole_numbers(data)};
  const Eigen::Vector3d between = (data.lights.places.col(0) + data.lights.places.rightCols(1)) / 2;
  for (const auto& view : data.views) {
    const RelitView relit = relight(*view, data.lights, between, one_after_the_other);
    contents.pictures.push_back(values_of(relit.lit));
    contents.pictures.push_back(values_of(relit.dark));
    contents.pictures.push_back(values_of(shadowed(relit, view->arrives.front())));
  }
  return contents;
}

}  // namespace sheen
