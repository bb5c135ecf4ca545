// SPDX-License-Identifier: Apache-2.0
// The page that `export` writes, in a real browser: its pictures against those of the ray painter.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "common/base/files.h"
#include "common/image/color.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/export_page.h"
#include "reconstructor/render/gl/orbit_camera.h"
#include "reconstructor/render/outlines.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/browser/page_checks.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

class ModelPage : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v chromium > /dev/null 2>&1") != 0) GTEST_SKIP() << "chromium is not installed";
    if (!fs::exists(SHEEN_PAGE_FOLDER "/light_field.wasm"))
      GTEST_SKIP() << "this build has no page (deploy/install packages-wasm.txt, then build again)";
  }
  TempFolder folder_;
};

TEST_F(ModelPage, ShowsThePicturesOfTheRayPainter) {
  const fs::path file = SHEEN_GOLDEN_FOLDER "/sphere.slf";
  write_page(file, folder_.path() / "page", page_text(file));
  const SavedModel saved = open_model(file);
  const Mesh& mesh = saved.snapshot->mesh();
  const std::vector<Eye> eyes = eyes_round(bounding_sphere(mesh), 8);
  const Shown shown = shown_in_browser(folder_.path(), eyes);
  EXPECT_EQ(shown.figures.at("failure"), "");
  ASSERT_EQ(shown.pictures.size(), eyes.size());

  const RayPainter painter(mesh);
  const Outlines outlines(mesh);
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const Rigid3 pose = look_at(eyes[i].place, eyes[i].target, eyes[i].up);
    const ImageU8 truth = straight_srgb8(painter.paint_smooth(*saved.snapshot, outlines, page_camera(), pose));
    const Difference off = difference(shown.pictures[i], truth, outlines.pixels(page_camera(), pose));
    EXPECT_GT(off.values, 10'000) << "eye " << i;
    EXPECT_EQ(off.missing, 0) << "eye " << i;
    EXPECT_LE(off.off, 3) << "eye " << i << ": no more than a pixel whose ray meets the edge of two triangles";
    EXPECT_LE(off.mean, 0.25) << "eye " << i;
  }
}

TEST_F(ModelPage, ShowsAnIrradianceFieldInAnyLight) {
  const fs::path file = SHEEN_GOLDEN_FOLDER "/relief.rif";
  write_page(file, folder_.path() / "page", page_text(file));
  const SavedModel saved = open_model(file);
  const PosedCamera& from = saved.snapshot->cameras().front();
  const RayPainter painter(saved.snapshot->mesh());
  std::vector<Eigen::Vector3d> lights{saved.snapshot->lights().front().position};
  for (int i = 0; i < 8; ++i) {
    const double turn = 2.4 * i, lean = 0.15 * i;
    lights.emplace_back(std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn), std::cos(lean));
  }
  const Shown shown = lit_in_browser(folder_.path(), lights);
  EXPECT_EQ(shown.figures.at("failure"), "");
  ASSERT_EQ(shown.pictures.size(), lights.size());
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const ImageU8 truth = to_srgb8(painter
                                       .paint(*saved.snapshot, from.camera, from.camera_from_object,
                                              {.kind = LightKind::kDirectional, .position = lights[i]})
                                       .beauty);
    const ImageU8& picture = shown.pictures[i];
    ASSERT_EQ(picture.width(), truth.width());
    ASSERT_EQ(picture.height(), truth.height());
    int most = 0;
    double mean = 0;
    for (int y = 0; y < truth.height(); ++y)
      for (int x = 0; x < truth.width(); ++x)
        for (int c = 0; c < 3; ++c) {
          const int off = std::abs(int{picture.at(x, y, c)} - int{truth.at(x, y, c)});
          most = std::max(most, off);
          mean += off;
        }
    EXPECT_LE(most, 2) << "light " << i;
    EXPECT_LE(mean / static_cast<double>(truth.size()), 0.25) << "light " << i;
  }
}

TEST_F(ModelPage, IsOneFileToo) {
  make_folder(folder_.path() / "page");
  for (const char* name : {"sphere.slf", "relief.rif"}) {
    const fs::path file = fs::path(SHEEN_GOLDEN_FOLDER) / name;
    write_single_page(file, folder_.path() / "page" / "index.html", page_text(file));
    const Shown shown = shown_in_browser(folder_.path(), std::vector<Eye>{});
    EXPECT_EQ(shown.figures.at("failure"), "") << name;
    EXPECT_EQ(shown.figures.at("state"), "whole") << name;
  }
}

TEST_F(ModelPage, ShowsTheSameAfterTheGraphicsWereLost) {
  const fs::path file = SHEEN_GOLDEN_FOLDER "/sphere.slf";
  write_page(file, folder_.path() / "page", page_text(file));
  const Shown shown =
      shown_in_browser(folder_.path(), std::vector<Eye>{{{1, -2, 0.5}, {0, 0, 0}, {0, 0, 1}}}, {.lose = true});
  EXPECT_EQ(shown.figures.at("failure"), "");
  ASSERT_EQ(shown.pictures.size(), 2);
  EXPECT_TRUE(std::equal(shown.pictures[0].data(), shown.pictures[0].data() + shown.pictures[0].size(),
                         shown.pictures[1].data()));
}

TEST_F(ModelPage, ACutFileIsAPictureAndADamagedOneANamedError) {
  const fs::path file = SHEEN_GOLDEN_FOLDER "/sphere.slf", page = folder_.path() / "page";
  const std::string bytes = read_file(file);
  write_page(file, page, page_text(file));
  write_file(page / "model.slf", bytes.substr(0, bytes.find("STAT")));
  const Shown cut = shown_in_browser(folder_.path(), std::vector<Eye>{{{1, -2, 0.5}, {0, 0, 0}, {0, 0, 1}}});
  EXPECT_EQ(cut.figures.at("failure"), "");
  EXPECT_GT(cut.figures.at("missingLayers"), 0);
  EXPECT_EQ(cut.pictures.size(), 1);

  std::string damaged = bytes;
  damaged[bytes.find("VERT") + 40] ^= 1;
  write_file(page / "model.slf", damaged);
  fs::remove_all(folder_.path() / "profile");
  const Shown none = shown_in_browser(folder_.path(), std::vector<Eye>{});
  EXPECT_EQ(none.figures.at("state"), "failed");
  EXPECT_THAT(none.figures.at("failure").get<std::string>(), ::testing::HasSubstr("chunk \"VERT\" is damaged"));
}

}  // namespace
}  // namespace sheen
