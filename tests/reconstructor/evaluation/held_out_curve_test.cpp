// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/evaluation/held_out_curve.h"

#include <gtest/gtest.h>

#include "common/base/angle.h"
#include "common/image/color.h"
#include "reconstructor/evaluation/held_out_set.h"
#include "tests/support/plain_model.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using testing::PlainModel;

/// A grey view of the square from an angle, degrees, of so many pixels per side.
HeldOutView view_from(double angle_deg, std::uint64_t sequence, int side = 40) {
  const double a = angle_deg * kDegree;
  HeldOutView view{.source_session = "run", .sequence = sequence};
  view.camera = {.width = side, .height = side, .fx = 1.5 * side, .fy = 1.5 * side, .cx = side / 2.0, .cy = side / 2.0};
  view.camera_from_object = look_at({0.5 * std::sin(a), 0, 0.5 * std::cos(a)}, {0, 0, 0}, {0, 1, 0});
  const ImageU8 all(side, side, 1, 255);
  view.pack({ImageU8(side, side, 3, 120), all, all});
  return view;
}

TEST(JudgingPanel, IsSpreadAndKeepsWhoIsInIt) {
  std::vector<HeldOutView> views;
  std::vector<std::size_t> before;
  for (const double angle : {0.0, 5.0, 30.0, 20.0, -40.0, 60.0, -70.0}) {
    views.push_back(view_from(angle, views.size() + 1));
    const std::vector<std::size_t> panel = judging_panel(views, Eigen::Vector3d::Zero());
    ASSERT_GE(panel.size(), before.size());
    EXPECT_TRUE(std::equal(before.begin(), before.end(), panel.begin())) << angle;
    before = panel;
  }
  EXPECT_EQ(before, (std::vector<std::size_t>{0, 2, 4, 5})) << "four are enough";
}

TEST(JudgingPanel, OfLargeViewsHasFewer) {
  std::vector<HeldOutView> views;
  for (const double angle : {0.0, 30.0, 60.0}) views.push_back(view_from(angle, views.size() + 1, 1500));
  EXPECT_EQ(judging_panel(views, Eigen::Vector3d::Zero()).size(), 1u);
}

TEST(HeldOutCurve, TheSameViewsJudgeEveryPointAndOthersBeginAnew) {
  const Mesh mesh = square_mesh(0.4f, 0, 4);
  const RayPainter painter(mesh);
  const auto model = [&](int grey) { return PlainModel(mesh, Eigen::Vector3f::Constant(srgb_decode(grey / 255.0f))); };
  std::vector<HeldOutView> views{view_from(0, 1), view_from(40, 2)};
  HeldOutCurve curve;
  for (int image = 1; image <= 5; ++image) {
    curve.judge(views, {0}, image, model(120 + 6 - image), model(140), painter);
    ASSERT_EQ(curve.points().size(), static_cast<std::size_t>(image));
    EXPECT_NEAR(curve.points().back().psnr_db, 20 * std::log10(255.0 / (6 - image)), 1e-9);
    EXPECT_NEAR(curve.points().back().constant_psnr_db, 20 * std::log10(255.0 / 20), 1e-9);
  }
  JudgedPixels pixels = views[1].pixels();
  std::fill_n(pixels.truth.data(), pixels.truth.size(), std::uint8_t{130});
  views[1].pack(pixels);
  curve.judge(views, {0, 1}, 6, model(121), model(140), painter);
  ASSERT_EQ(curve.points().size(), 1u);
  EXPECT_NEAR(curve.points().back().psnr_db, (20 * std::log10(255.0) + 20 * std::log10(255.0 / 9)) / 2, 1e-9);
  curve.judge(views, {0, 1}, 7, model(121), model(140), painter);
  EXPECT_EQ(curve.points().size(), 2u);
}

TEST(HeldOutCurve, IsBoundedHoweverLongTheCapture) {
  HeldOutCurve curve;
  for (std::uint64_t image = 1; image <= 100000; ++image) {
    curve.add({.images = image});
    ASSERT_LE(curve.points().size(), HeldOutCurve::kMostPoints);
  }
  EXPECT_EQ(curve.points().front().images, 1u);
  EXPECT_EQ(curve.points().back().images, 100000u);
  EXPECT_TRUE(std::is_sorted(curve.points().begin(), curve.points().end(),
                             [](const auto& a, const auto& b) { return a.images < b.images; }));
}

TEST(HeldOutSet, StaysSpreadOverTheCaptureAndWithinItsMemory) {
  const HeldOutView view = view_from(0, 1);
  const double most = 20.5 * static_cast<double>(view.packed.size());
  HeldOutSet set(most);
  for (std::uint64_t sequence = 1; sequence <= 1000; ++sequence) {
    if (!set.takes_next()) continue;
    HeldOutView next = view;
    next.sequence = sequence;
    set.add(std::move(next));
    ASSERT_LE(set.bytes(), most);
  }
  const std::vector<HeldOutView>& kept = set.views();
  ASSERT_GE(kept.size(), 10u);
  EXPECT_EQ(kept.front().sequence, 1u);
  for (std::size_t i = 1; i < kept.size(); ++i)
    EXPECT_EQ(kept[i].sequence - kept[i - 1].sequence, kept[1].sequence - kept[0].sequence);
  EXPECT_GT(kept.back().sequence, 900u);
  set.erase("another", 1);
  EXPECT_EQ(set.views().front().sequence, 1u);
  set.erase("run", 1);
  EXPECT_GT(set.views().front().sequence, 1u);
}

TEST(HeldOutSet, AFewAreKeptWhateverTheyTake) {
  HeldOutSet set(1);
  for (std::uint64_t sequence = 1; sequence <= 100; ++sequence)
    if (set.takes_next()) set.add(view_from(0, sequence));
  EXPECT_GE(set.views().size(), HeldOutSet::kFewest / 2);
  EXPECT_LE(set.views().size(), HeldOutSet::kFewest);
}

}  // namespace
}  // namespace sheen
