// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_file.h"
#include "reconstructor/lumigraph_file/encode/lumigraph_encoding.h"
#include "reconstructor/lumigraph_file/lumigraph_reader.h"

#include <gtest/gtest.h>

#include <cstring>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/models/intrinsic_lumigraph/lumigraph_painter.h"
#include "tests/reconstructor/models/intrinsic_lumigraph/small_rig.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

class LumigraphFileTest : public ::testing::Test {
 protected:
  LumigraphFileTest() {
    IntrinsicLumigraph model(rig_.mesh, {});
    for (std::size_t l = 0; l < 3; ++l) model.ingest(rig_.capture(0, l));
    model.ingest(rig_.capture(1, 1));
    saved_ = SmallRig::snapshot_of(model);
    bytes_ = encode_lumigraph(*saved_->data());
  }
  const SmallRig rig_;
  const TempFolder temp_;
  std::shared_ptr<const IntrinsicLumigraphSnapshot> saved_;
  std::string bytes_;
};

TEST_F(LumigraphFileTest, AReopenedModelIsTheSameToTheBit) {
  saved_->save(temp_.path() / "model", {{"source", "a test"}}, {});
  const auto again = load_lumigraph(temp_.path() / "model");
  const LightState& light = rig_.rig.midway_lights()[1];
  for (const PosedCamera& from : {rig_.rig.cameras()[0], rig_.rig.camera_at(0.5, 0)})
    EXPECT_EQ(LumigraphPainter(again).paint(from, light), LumigraphPainter(saved_).paint(from, light));
  EXPECT_EQ(again->cameras().size(), 2u);
  EXPECT_EQ(again->light_kind(), LightKind::kPoint);
}

TEST_F(LumigraphFileTest, AModelOfImagesKeepsItsHull) {
  LumigraphData data = *saved_->data();
  data.of_images = true;
  data.hull = ShadowHull({1, -2, 0.5f}, 0.01f, {3, 2, 2}, {15, 0, 3, 1, 1, 0, 7, 0, 15, 0, 0, 14});
  const LumigraphData again = read_lumigraph(encode_lumigraph(data), "views.ilg");
  EXPECT_TRUE(again.of_images);
  EXPECT_EQ(again.hull.cells(), data.hull.cells());
  EXPECT_EQ(again.hull.size(), data.hull.size());
  EXPECT_EQ(again.hull.origin(), data.hull.origin());
  EXPECT_EQ(again.hull.cell(), data.hull.cell());

  data.hull = ShadowHull({1, -2, 0.5f}, 0.01f, {30, 2, 2}, {1, 0, 0, 1});
  EXPECT_THROW(read_lumigraph(encode_lumigraph(data), "views.ilg"), FileError) << "fewer cells than it says";
  data.hull = ShadowHull({1, -2, 0.5f}, 0.01f, {2, 2, 1}, {1, 0, 16, 1});
  EXPECT_THROW(read_lumigraph(encode_lumigraph(data), "views.ilg"), FileError) << "more than solid";
  data.hull = ShadowHull({1, -2, 0.5f}, 0.01f, {1 << 13, 1 << 13, 1 << 13}, {});
  EXPECT_THROW(read_lumigraph(encode_lumigraph(data), "views.ilg"), FileError) << "more than any honest file";
}

TEST_F(LumigraphFileTest, DamageIsNoticed) {
  for (const std::size_t at : {std::size_t{3}, std::size_t{9}, bytes_.size() / 3, bytes_.size() - 5}) {
    std::string broken = bytes_;
    broken[at] = static_cast<char>(broken[at] ^ 0x20);
    EXPECT_THROW(read_lumigraph(broken, "views.ilg"), FileError) << "byte " << at;
  }
  for (const std::size_t length : {std::size_t{0}, std::size_t{11}, bytes_.size() / 2, bytes_.size() - 1})
    EXPECT_THROW(read_lumigraph(std::string_view(bytes_).substr(0, length), "views.ilg"), FileError) << length;
}

TEST_F(LumigraphFileTest, WhatCannotBeIsRefused) {
  const auto refused = [&](const std::function<void(LumigraphData&, IntrinsicView&)>& spoil) {
    LumigraphData data = *saved_->data();
    IntrinsicView view = *data.views[0];
    spoil(data, view);
    data.views[0] = std::make_shared<const IntrinsicView>(view);
    EXPECT_THROW(read_lumigraph(encode_lumigraph(data), "views.ilg"), FileError);
  };
  refused([](LumigraphData& data, IntrinsicView&) { data.lights.kind = LightKind::kEnvironment; });
  refused([](LumigraphData& data, IntrinsicView&) { data.lights.places(1, 1) = std::nan(""); });
  refused([](LumigraphData& data, IntrinsicView&) { data.error = -1; });
  refused([](LumigraphData&, IntrinsicView& view) { view.lights[1] = 99; });
  refused([](LumigraphData&, IntrinsicView& view) { view.lights[1] = view.lights[0]; });
  refused([](LumigraphData&, IntrinsicView& view) { view.from.camera.width = 7; });
  refused([](LumigraphData&, IntrinsicView& view) { view.residual_unit = -1; });
  refused([](LumigraphData&, IntrinsicView& view) { view.depth.at(3, 3) = std::nanf(""); });
  refused([](LumigraphData&, IntrinsicView& view) { view.slope.at(3, 3) = Eigen::half(INFINITY); });
}

}  // namespace
}  // namespace sheen
