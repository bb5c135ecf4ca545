// SPDX-License-Identifier: Apache-2.0
// The page of a running capture, in a real browser: its pictures against those of the ray painter, while the model
// grows.
#include <gtest/gtest.h>

#include <cstdlib>

#include "reconstructor/capture/live_model.h"
#include "reconstructor/models/surface_light_field/kind.h"
#include "reconstructor/monitor/monitor_server.h"
#include "reconstructor/render/outlines.h"
#include "reconstructor/render/ray_painter.h"
#include "tests/browser/page_checks.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

class LivePage : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v chromium > /dev/null 2>&1") != 0) GTEST_SKIP() << "chromium is not installed";
    model_.watch(surface_light_field_kind(), observer_);
  }
  std::shared_ptr<const ModelSnapshot> grown(SurfaceLightField& model, const std::vector<Eigen::Vector3d>& eyes) {
    ingest_all(model, captures(scene_, eyes));
    std::shared_ptr<const ModelSnapshot> snapshot = model.snapshot();
    observer_.on_snapshot(snapshot, nullptr);
    return snapshot;
  }

  Object object_ = sphere_object();
  analytic::Scene scene_{object_.surface, analytic::two_terms(0.05)};
  LiveModel model_;
  LoopObserver observer_;
  MonitorServer server_{{.port = 0, .model = &model_}};
  TempFolder folder_;
};

TEST_F(LivePage, ShowsTheModelAsItGrows) {
  SurfaceLightField model(object_.mesh, plain_options());
  const std::vector<std::vector<Eigen::Vector3d>> visits{
      {{0, 0, 0.5}, {0.1, 0, 0.49}, {0, 0.15, 0.48}}, analytic::eyes(12, 0.5, 0.3), analytic::eyes(9, 0.45, -0.9, 0.2)};
  std::vector<std::shared_ptr<const ModelSnapshot>> snapshots{grown(model, visits[0])};
  const std::vector<Eye> eyes = eyes_round(bounding_sphere(*object_.mesh), 3);
  std::vector<std::size_t> snapshot_of;  // per picture
  const Shown shown =
      shown_in_browser(folder_.path(), eyes, {.port = server_.port(), .change = [&](std::size_t) {
                                                snapshot_of.push_back(snapshots.size() - 1);
                                                if (snapshots.size() == visits.size()) return false;
                                                snapshots.push_back(grown(model, visits[snapshots.size()]));
                                                return true;
                                              }});
  EXPECT_EQ(shown.figures.at("failure"), "");
  ASSERT_EQ(shown.pictures.size(), eyes.size() + 2);

  const RayPainter painter(*object_.mesh);
  const Outlines outlines(*object_.mesh);
  for (std::size_t i = 0; i < shown.pictures.size(); ++i) {
    const Eye& eye = eyes[i < 2 ? 0 : i - 2];
    const Rigid3 pose = look_at(eye.place, eye.target, eye.up);
    const ImageU8 truth =
        straight_srgb8(painter.paint_smooth(*snapshots[snapshot_of[i]], outlines, page_camera(), pose));
    ImageU8 left_out = outlines.pixels(page_camera(), pose);
    for (int y = 0; y < kPageHeight; ++y)
      for (int x = 0; x < kPageWidth; ++x)  // what no image showed is black there, and striped on the page
        if (truth.at(x, y, 3) > 0 && truth.at(x, y, 0) + truth.at(x, y, 1) + truth.at(x, y, 2) == 0)
          left_out.at(x, y) = 255;
    const Difference off = difference(shown.pictures[i], truth, left_out);
    EXPECT_GT(off.values, 10'000) << "picture " << i;
    EXPECT_EQ(off.missing, 0) << "picture " << i;
    EXPECT_LE(off.off, 3 + off.values / 1000) << "picture " << i;
    EXPECT_LE(off.mean, 0.35) << "picture " << i;
  }
}

}  // namespace
}  // namespace sheen
