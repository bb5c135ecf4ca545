// SPDX-License-Identifier: Apache-2.0
// The stored files of the models whose light moves are read by this build as by the one that wrote them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/base/crc32c.h"
#include "common/base/files.h"
#include "common/image/color.h"
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_file.h"
#include "reconstructor/models/irradiance_field/field_file.h"
#include "tests/golden/contents.h"

namespace sheen {
namespace {

const std::filesystem::path kFolder = SHEEN_GOLDEN_FOLDER;

FileContents expected(const std::string& name) {
  return FileContents::parsed(read_file(kFolder / (name + ".txt")));
}

template <typename Number>
FileContents::Part part(const std::string& name, const Number* numbers, std::size_t count) {
  return {name, crc32c({reinterpret_cast<const std::uint8_t*>(numbers), count * sizeof(Number)})};
}

TEST(GoldenFiles, AnIrradianceField) {
  const auto field = load_field(kFolder / "relief.rif");
  FileContents found;
  for (std::size_t c = 0; c < 3; ++c) {
    const QuantisedField::Component& component = field->field().components[c];
    found.whole_numbers.push_back(part("basis", component.basis.data(), component.basis.size()));
    found.whole_numbers.push_back(part("maps", component.coefs.data(), component.coefs.size()));
  }
  const ImageU8 picture = field->screen_picture(
      {.kind = LightKind::kDirectional, .position = Eigen::Vector3d(0.3, -0.2, 0.9).normalized()});
  auto& values = found.pictures.emplace_back();
  for (std::size_t i = 0; i < picture.size(); i += 17) values.push_back(picture.data()[i]);
  EXPECT_EQ(differences(expected("relief.rif"), found), "") << found.text();
}

TEST(GoldenFiles, AnIntrinsicLumigraph) {
  const auto file = kFolder / "views.ilg";
  const LumigraphData data = decode_lumigraph(read_file(file), file.string());
  FileContents found;
  for (const auto& view : data.views) {
    found.whole_numbers.push_back(part("depth", view->depth.data(), view->depth.size()));
    found.whole_numbers.push_back(part("reflectance", view->reflectance.data(), view->reflectance.size()));
    for (std::size_t l = 0; l < view->lights.size(); ++l) {
      found.whole_numbers.push_back(part("arrives", view->arrives[l].data(), view->arrives[l].size()));
      found.whole_numbers.push_back(part("residual", view->residual[l].data(), view->residual[l].size()));
    }
  }
  EXPECT_EQ(differences(expected("views.ilg"), found), "") << found.text();
}

}  // namespace
}  // namespace sheen
