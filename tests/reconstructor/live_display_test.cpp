// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/live_display.h"

#include <gtest/gtest.h>

#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

TEST(LiveDisplay, SaysWhetherImagesAreStillToCome) {
  const Mesh mesh = square_mesh(0.1f, 0, 1);
  const RayPainter painter(mesh);
  LiveDisplay display(painter, {});
  const auto shown = [&](const LoopStatus& status) {
    display.publish_to_window(status);
    return display.feed().latest()->link;
  };
  LoopStatus status;
  EXPECT_EQ(shown(status), TrackerLink::kWaiting);
  status.link.ended = true;
  EXPECT_EQ(shown(status), TrackerLink::kEnded) << "not a saved model that is looked at";
}

}  // namespace
}  // namespace sheen
