// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/page/wasm/page_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/light_field_file/light_field_evaluator.h"
#include "reconstructor/light_field_file/light_field_file.h"

namespace sheen {
namespace {

using Stage = PageModel::Stage;

std::string sphere() {
  return read_file(SHEEN_GOLDEN_FOLDER "/sphere.slf");
}

/// What a file of so many bytes, all that there is, comes to.
Stage stage_of(const std::string& bytes) {
  PageModel model("m.slf");
  Stage last = Stage::kNothing;
  for (Stage stage = model.read(bytes, true); stage != Stage::kNothing; stage = model.read(bytes, true)) last = stage;
  if (last == Stage::kTerms)
    while (!model.next_terms().empty()) continue;
  if (last == Stage::kTerms) model.look_from({1, 2, 3});
  return last;
}

TEST(PageModel, ShowsMeshMeansAndTermsAsTheFileArrives) {
  const std::string bytes = sphere();
  PageModel model("m.slf");
  std::vector<Stage> stages;
  for (std::size_t arrived = 0; arrived <= bytes.size(); arrived += 100)
    for (Stage stage = model.read(bytes.substr(0, arrived), false); stage != Stage::kNothing;
         stage = model.read(bytes.substr(0, arrived), false))
      stages.push_back(stage);
  EXPECT_THAT(stages, testing::ElementsAre(Stage::kMesh, Stage::kMeans));
  EXPECT_EQ(model.read(bytes, true), Stage::kTerms);
  EXPECT_EQ(model.read(bytes, true), Stage::kNothing);
}

/// The colour of a sample of a triangle, as the page's shader puts it together.
Eigen::Vector3f shown(const PageModel& model, const std::vector<std::uint8_t>& terms, std::size_t triangle, int sample,
                      const Eigen::Vector3f& beta) {
  const std::uint32_t* place = &model.places()[12 * triangle];
  float low = 0, range = 0;
  std::memcpy(&low, place + 10, sizeof low);
  std::memcpy(&range, place + 11, sizeof range);
  const std::uint8_t* mean = &model.means()[4 * (place[7] + static_cast<std::size_t>(sample))];
  Eigen::Vector3f colour;
  for (int c = 0; c < 3; ++c) colour[c] = low + range * static_cast<float>(mean[c]) / 255;
  for (std::uint32_t r = 0; r < place[9]; ++r) {
    float amount = 0;
    for (int c = 0; c < 3; ++c) amount += beta[c] * model.coefficients()(r, place[4 + c]);
    const std::uint8_t* term = &terms[4 * (place[8] + static_cast<std::size_t>(sample) * place[9] + r)];
    for (int c = 0; c < 3; ++c) colour[c] += amount * (static_cast<float>(term[c]) - 128) / 255;
  }
  return colour;
}

TEST(PageModel, GivesTheColoursOfTheEvaluator) {
  const std::string bytes = sphere();
  const Eigen::Vector3d eye(1.5, -2, 0.8);
  PageModel page("m.slf");
  while (page.read(bytes, true) != Stage::kTerms) continue;
  std::vector<std::uint8_t> terms;
  while (!page.next_terms().empty()) terms.insert(terms.end(), page.terms().begin(), page.terms().end());
  page.look_from(eye);
  CompactModel model = decode_light_field(bytes, "m.slf", one_after_the_other);
  const LightFieldEvaluator evaluator(model, one_after_the_other);
  const Eigen::MatrixXf coefficients = evaluator.coefficients_for(eye, one_after_the_other);
  double sum = 0;
  float most = 0;
  for (std::size_t t = 0; t < model.mesh->triangles.size(); ++t) {
    const TrianglePlace place = evaluator.shapes().place(t);
    const SurfacePatch* patch = evaluator.patches()[place.patch].get();
    if (!patch) continue;
    const LatticeStencil corner = lattice_stencil(model.maps->resolution(t), 1, 0);
    const Eigen::Vector3f truth = patch->colour(place, corner, coefficients, 1, 0);
    const int at = corner.weight[0] > 0.5f ? 0 : corner.weight[1] > 0.5f ? 1 : 2;
    const float off = 255 * (shown(page, terms, t, corner.index[at], {0, 1, 0}) - truth).cwiseAbs().maxCoeff();
    most = std::max(most, off);
    sum += off;
  }
  EXPECT_LT(most, 2);
  EXPECT_LT(sum / static_cast<double>(model.mesh->triangles.size()), 0.5);
}

TEST(PageModel, ACutFileIsAPictureFromTheFirstMeansOn) {
  const std::string bytes = sphere();
  const std::size_t enough = bytes.find("STAT");
  ASSERT_NE(enough, std::string::npos);
  for (std::size_t size = enough; size <= bytes.size(); size += 97)
    EXPECT_EQ(stage_of(bytes.substr(0, size)), Stage::kTerms) << size;
  EXPECT_THROW(stage_of(bytes.substr(0, enough / 2)), FileError);
  EXPECT_THROW(stage_of(""), FileError);
}

TEST(PageModel, DamageIsANamedErrorOrAPicture) {
  const std::string bytes = sphere();
  std::mt19937 random(3);
  for (int i = 0; i < 1000; ++i) {
    std::string damaged = bytes;
    for (std::size_t n = 1 + random() % 4; n > 0; --n)
      damaged[random() % damaged.size()] ^= static_cast<char>(1 + random() % 255);
    if (random() % 2 == 0) damaged.resize(random() % damaged.size());
    try {
      EXPECT_EQ(stage_of(damaged), Stage::kTerms);
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith("m.slf"));
    }
  }
}

}  // namespace
}  // namespace sheen
